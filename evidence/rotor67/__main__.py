"""The benchmark of rotor 67: frequencies and response of inputs/rotor67/rotor67.h5, as numbers.

With `--sections FILE` it begins at the published sections and makes that model anew (CalculiX; 10
minutes); ends with 1 when a frequency is not that of CalculiX. At the scale 1 it writes
inputs/rotor67/numbers.csv, the figures and the tables of docs/rotor67.md. At a smaller scale it
computes fewer fans, and prints its numbers beside those of that file.
"""

import argparse
from pathlib import Path

import hpcrub
from evidence import pictures
from evidence.page import DOCS
from evidence.rotor67 import (
    bending,
    frequencies,
    model,
    numbers,
    page,
    response,
    sections,
    stress,
)
from hpcrub.model.imported import neutral
from hpcrub.model.imported.bending import onto
from hpcrub.results import model_file

MODEL = Path("inputs/rotor67/rotor67.h5")
FIGURES = DOCS / "figures"
CHECK = 1e-5  # largest relative difference from frequencies that CalculiX prints


def main(argv=None):
    """Run all steps; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.rotor67", description=__doc__)
    parser.add_argument("--sections", type=Path, help=".npz of the published sections")
    parser.add_argument("--scale", type=float, default=1.0, help="share of the mistuned fans")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=Path("build/rotor67"))
    options = parser.parse_args(argv)
    folder, found = options.folder, []
    folder.mkdir(parents=True, exist_ok=True)
    full = options.scale >= 1
    figures = FIGURES if full else folder
    path, difference = MODEL, 0.0
    if options.sections:
        path = MODEL if full else folder / MODEL.name
        found, difference = from_sections(options.sections, path, folder, figures)
    fan = neutral.from_arrays(model_file.read(path))
    found += frequencies.numbers(fan, figures / "rotor67_campbell.png")
    found += response.numbers(path, options.scale, options.ranks, folder, figures)
    if full:
        numbers.write(numbers.TABLE, found)
        page.write(numbers.read(numbers.TABLE))
    else:
        numbers.write(folder / numbers.TABLE.name, found)
        numbers.show(numbers.compare({n[:2]: n for n in found}, numbers.read(numbers.TABLE)))
    return int(not difference <= CHECK)


def from_sections(path: Path, output: Path, folder: Path, figures: Path) -> tuple[list, float]:
    """Make the model file; returns numbers, and the largest difference from CalculiX's own."""
    blade = sections.read(path)
    found = frequencies.converged(blade, folder)
    fan = model.shapes(blade, folder)
    found += model.numbers(fan)
    sectors = model.matrices(fan, folder)
    found += stress.numbers(fan, sectors[model.DESIGN])
    places = stress.places_of(fan, sectors[model.DESIGN])
    sectors[model.DESIGN] = stress.with_rows(fan, sectors[model.DESIGN])
    arrays = model.reduced(fan, sectors, model.blade_alone(fan, folder))
    alone, bent = model.bent_blade(fan, folder)
    whole = onto(neutral.from_arrays(arrays), alone, bent)
    own = bending.blade_of(alone, bent, whole.contact_normal[: model.POINTS])
    found += bending.numbers(fan, own, places, folder)
    model_file.write(output, neutral.to_arrays(whole), overwrite=True)
    model_file.write(folder / "sector.h5", neutral.to_arrays(sectors[model.DESIGN]), overwrite=True)
    axes = hpcrub.plot.model(folder / "sector.h5")
    pictures.save(axes.figure, figures / "rotor67_mesh.png", dpi=110)
    difference = frequencies.held_against_calculix(fan, sectors[model.DESIGN], folder)
    print(f"one sector at the design speed, beside CalculiX: {difference:.1e} (at most {CHECK:g})")
    return found, difference


if __name__ == "__main__":
    raise SystemExit(main())
