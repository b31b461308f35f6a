"""The contact study: the frequency response in contact of many disks drawn at random."""

from hpcrub.studies.contact.study import STUDY

__all__ = ["STUDY"]
