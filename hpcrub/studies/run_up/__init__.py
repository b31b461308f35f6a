"""The run_up study: disks while the rotor gains and loses speed."""

from hpcrub.studies.run_up.study import STUDY

__all__ = ["STUDY"]
