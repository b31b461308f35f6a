"""`Config`, the whole input of a study, and its reading from YAML text and overrides."""

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError, model_validator

from hpcrub.config import checks as config_checks
from hpcrub.config import resolution, run_up, samples, sections, study_keys, yaml_text
from hpcrub.config import runs as config_runs
from hpcrub.config import text as config_text
from hpcrub.config.aero import Aero
from hpcrub.config.casing import Casing
from hpcrub.config.disk import Disk, Material, Reduction
from hpcrub.config.types import FileName, Files, Section
from hpcrub.errors import InputError, reading
from hpcrub.model import families
from hpcrub.model.damping import Damping

SPRING_BACK_S = 1e-5  # default of time.step_s with an elastic casing or a coating [s]
# keys of harmonics and profile: long lists of numbers, for which `Casing.words` is a short text
PROFILE = "casing.harmonics", "casing.profile_csv", "casing.profile_deg", "casing.profile_mm"


class Config(Section):
    """The whole input of one study."""

    study: study_keys.StudyName = "contact"
    """what is computed"""
    output: FileName = "results/quickstart.h5"
    """result file; a file without this key gets results/(its name).h5"""
    sources: Files = ()
    """result file of the contact study that an energy study starts from"""
    disk: Disk = Disk()
    material: Material = Material()
    reduction: Reduction = Reduction()
    casing: Casing = Casing()
    aero: Aero = Aero()
    contact: sections.Contact = sections.Contact()
    forcing: sections.Forcing = sections.Forcing()
    speeds: sections.Speeds = sections.Speeds()
    time: sections.Time = sections.Time()
    steady_state: sections.SteadyState = sections.SteadyState()
    mistuning: sections.Mistuning = sections.Mistuning()
    convergence: sections.Convergence = sections.Convergence()
    limits: sections.Limits = sections.Limits()
    part: study_keys.Part = study_keys.Part()
    linear: study_keys.Linear = study_keys.Linear()
    history: study_keys.History = study_keys.History()
    spectrum: study_keys.Spectrum = study_keys.Spectrum()
    energy: study_keys.Energy = study_keys.Energy()
    branches: study_keys.Branches = study_keys.Branches()
    checklist: study_keys.Checklist = study_keys.Checklist()
    patterns: study_keys.Patterns = study_keys.Patterns()
    threshold: study_keys.Threshold = study_keys.Threshold()
    run_up: study_keys.RunUp = study_keys.RunUp()

    def __init__(self, /, **keys: Any) -> None:
        """Validate sections and keys. Raises InputError as `from_yaml`."""
        try:
            super().__init__(**keys)
        except ValidationError as error:
            raise InputError(config_text.first_error(type(self), error)) from None

    @model_validator(mode="after")
    def _complete(self) -> Any:
        """Fill in missing keys that others decide, and the tip radius in the casing."""
        if self.pattern_deviation is not None:  # one sample on one level as wide as the pattern
            width = float(np.abs(self.pattern_deviation).max()) * 100
            self._fill_in("mistuning", {"samples": 1, "half_range_percent": (width,)})
        elif (asked := samples.of_question(self)) is not None:
            last = type(self.mistuning).model_fields["half_range_percent"].default[-1:]
            self._fill_in("mistuning", {"samples": asked, "half_range_percent": last})
        if run_up.runs_up(self):
            low, high = sorted(run_up.ends_of(self))
            self._fill_in("speeds", {"from_hz": low, "to_hz": high})
        if self.contact.law != "rigid":  # the end of a long step takes stored energy
            self._fill_in("time", {"step_s": SPRING_BACK_S})
        casing = self.casing.model_copy()
        casing._tip_radius_mm = self.disk.tip_radius_mm
        object.__setattr__(self, "casing", casing)
        return self

    def _fill_in(self, name: str, decided: Any) -> None:
        """Set keys that the input does not give; `replace` decides anew, as they count as unset."""
        section = getattr(self, name)
        given = section.model_fields_set
        values = dict(section) | {key: decided[key] for key in decided.keys() - given}
        object.__setattr__(self, name, type(section).model_construct(given, **values))

    @model_validator(mode="after")
    def _keys_fit_together(self) -> Any:
        if problems := list(config_checks.problems(self)):
            raise ValueError("\n".join(problems))
        return self

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates of the reduced model: contact points and fixed-interface modes."""
        n_modes = self.reduction.n_modes
        if self.disk.model is None:
            n_modes = families.whole(n_modes, self.disk.n_blades)
        return (self.disk.n_directions or 2) * self.disk.n_points + n_modes

    @property
    def damping(self) -> float | Damping:
        """Damping ratio of all modes, or a Damping with ratios of single modes [-]."""
        material = self.material
        if material.damping_ratios is None:
            return material.damping_ratio
        family = {"modes": 1, "families": self.disk.n_blades, "bands": 1}[material.damping_of]
        bands = tuple(2.0 * np.pi * f for f in material.damping_bands_hz or ())
        return Damping(material.damping_ratios, family, bands)

    @property
    def observes_stress(self) -> bool:
        """Whether stresses are computed: they must have a limit, and the disk must know them."""
        limits = self.limits
        known = self.disk.model is None or self.disk.n_stresses > 0
        return limits.stress_mpa is not None and limits.stress_mpa_per_mm is None and known

    @property
    def is_goodman(self) -> bool:
        """Whether the stress of rotation raises all stresses (Goodman), see `setup.problem`."""
        return self.disk.static_mpa is not None and self.limits.strength_mpa is not None

    @property
    def engine_order(self) -> int | None:
        """Periods of the load around the casing; None if the input does not tell them."""
        casing = self.casing
        if self.forcing.engine_order is not None:
            return self.forcing.engine_order
        if casing.bump_height_mm > 0.0 or not casing.profile.exists:
            return casing.n_bumps
        orders = {order for order, *_ in casing.profile.harmonics}
        return orders.pop() if len(orders) == 1 and not casing.profile.measured else None

    @property
    def clearance(self) -> float:
        """Smallest clearance of the casing at any speed [m]."""
        return float(self.casing.clearances(self.speeds.values_hz).min())

    @property
    def step(self) -> float:
        """Longest time step at the highest speed [s], at which bumps need the shortest steps."""
        of_bumps = resolution.bump_time(self) / self.time.steps_per_bump_width
        return min(resolution.longest_step(self), of_bumps)

    @property
    def is_part(self) -> bool:
        """Whether the result file holds only a part of the study."""
        return self.part != study_keys.Part()

    @property
    def levels(self) -> tuple[int, ...]:
        """Numbers of the mistuning levels (V,)."""
        return tuple(range(len(self.mistuning.half_range_percent)))

    @property
    def samples(self) -> range:
        """Samples of this file on each level, numbered as in the whole study."""
        return range(*(self.part.samples or (0, self.mistuning.samples)))

    @property
    def pattern_deviation(self) -> np.ndarray | None:
        """Relative stiffness deviations of the blades of a pattern (N,); None without a pattern."""
        values, unit = self.mistuning.pattern, self.mistuning.pattern_unit
        if values is None or isinstance(values, str):
            return None
        return config_checks.deviation_of(values, unit, self.material.young_modulus_gpa)

    def replace(self, keys: Mapping[str, Any]) -> "Config":
        """Copy with some keys replaced, as if the input had given them, validated again.

        keys: values by their paths or sections, {"casing.n_bumps": 3, "study": "modal"} or
        {"casing": {"n_bumps": 3}, "study": "modal"}; all other keys stay. An element of a list has
        its number in the path, as in casing.harmonics[0].amplitude_mm.
        Raises InputError as `from_yaml`.
        """
        if not isinstance(keys, Mapping):
            raise InputError(f"{config_text.show(keys)} does not replace keys, as {{path: value}}")
        data = self.model_dump(mode="json", exclude_unset=True)
        for path, value in config_text.flatten(dict(keys)).items():
            config_text.set_key(data, path, value)
        return Config(**data)

    def value(self, path: str) -> Any:
        """Value of a key, or of an element of a list, by its path; None without one."""
        return config_text.value_at(self.model_dump(mode="json"), path)

    def by_path(self) -> dict[str, Any]:
        """Values of all keys as in an input file, {"casing.n_bumps": 4, ...}."""
        return config_text.flatten(self.model_dump(mode="json"))

    def to_yaml(self) -> str:
        """YAML text of all keys, which `from_yaml` reads back."""
        return yaml_text.dump(self.model_dump(mode="json"))

    @classmethod
    @lru_cache(maxsize=8)  # a long text takes seconds, and each part of a study holds the same one
    def from_yaml(cls, text: str) -> "Config":
        """Validated configuration from a YAML text with any of the keys.

        Raises InputError, which names the first wrong key, its value and the allowed values.
        """
        return cls(**_mapping(text))


def load_runs(path: str | Path, overrides: Iterable[str] = ()) -> list[Config]:
    """Load the configuration of an input file, or the configurations of all its `runs`.

    overrides: texts "key.path=value" that replace keys of the file.
    Raises InputError when the file cannot be read, and as `Config.from_yaml`.
    """
    with reading(path), open(path, encoding="utf-8-sig") as file:
        text = file.read(yaml_text.MAX_CHARACTERS + 1)
    try:
        data = _mapping(text)
        given = [config_text.apply_override(data, override) for override in overrides]
        data.setdefault("output", f"results/{Path(path).stem}.h5")
        return [Config(**run) for run in config_runs.expand(data, given)]
    except InputError as error:
        raise InputError(config_text.one_line(f"{path}: {error}")) from None


def differences(
    a: Config, b: Config, where: tuple[str, str] = ("in the file", "asked for")
) -> list[str]:
    """Keys, other than `output`, in which two configurations differ; where: words for a and b.

    Returns lines such as "casing.n_bumps: 4 in the file, 3 asked for".
    """
    first, second, show = a.by_path(), b.by_path(), config_text.show
    return [
        f"{key}: {show(first[key])} {where[0]}, {show(second[key])} {where[1]}"
        for key in first
        if key != "output" and first[key] != second[key]
    ]


def _mapping(text: str) -> Any:
    data = yaml_text.parse(text)
    if not isinstance(data, dict):
        raise InputError("no keys found; a line such as 'study: contact' is expected")
    return data
