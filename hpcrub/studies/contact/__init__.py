"""The contact study: the frequency response in contact of many disks drawn at random."""
