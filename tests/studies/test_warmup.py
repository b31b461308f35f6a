"""What is said about compiled code, once for all ranks."""

from types import SimpleNamespace

import numba

from hpcrub.config.schema import Config
from hpcrub.contact import jit
from hpcrub.ranks.parallel import Team
from hpcrub.studies import warmup


def test_a_folder_of_compiled_code_that_cannot_be_written_is_told_once(
    tmp_path, monkeypatch, capfd
):
    """For all ranks by rank 0, whichever of them it is that cannot."""
    monkeypatch.setattr(jit, "cache", SimpleNamespace(lost=""))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(warmup, "_load", lambda config: None)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert jit._cache_folder() == ""
    assert "Not a directory" in jit.cache.lost
    team = Team()
    warmup.warm_up(team, Config())
    err = capfd.readouterr().err
    assert err.count("\n") == err.count("compiled code cannot be kept on 1 of 1 ranks") == 1
    assert "XDG_CACHE_HOME=" in err
    team.size, team.gather = 3, lambda own: ["", jit.cache.lost, ""]
    team.bcast = lambda value: value
    warmup.warm_up(team, Config())
    assert "cannot be kept on 1 of 3 ranks" in capfd.readouterr().err
    team.rank = 2
    team.gather = team.on_root = lambda *_: None
    warmup.warm_up(team, Config())
    assert capfd.readouterr().err == ""
