"""Instructions of the kernel's inner loops on machines that need not be at hand.

numba makes the planar predictor for the shape that the rule gives a machine, without optimizing;
LLVM then optimizes it for that machine, and the loops of its assembly are counted. Nothing is run.
"""

import json
import os
import re
import subprocess
import tempfile

from evidence.page import table
from evidence.program import run
from hpcrub.contact.machine import SMALL_CACHE, Machine, shape_for

MACHINES = {  # registers, numbers of one, triple and processor of LLVM
    "AVX2 (Zen 3)": (16, 4, "x86_64-unknown-linux-gnu", "znver3"),
    "AVX-512 (Zen 4)": (32, 8, "x86_64-unknown-linux-gnu", "znver4"),
    "NEON (Neoverse N1)": (32, 2, "aarch64-unknown-linux-gnu", "neoverse-n1"),
    "NEON (Apple M1)": (32, 2, "arm64-apple-macosx", "apple-m1"),
}
JUMP = re.compile(r"\s+(?:j\w+|b|b\.\w+|cbn?z|tbn?z)\s.*?(\.?L\w+)$")
FUSED, PRODUCT = re.compile(r"\t(?:vfn?m|fml)"), re.compile(r"\t(?:vmul|fmul)")
LOAD = re.compile(r"\tld|\tv.*\(.*\).*, %[xyz]mm\d+")
STORE = re.compile(r"\tst|\tvmov\w+\s+%[xyz]mm\d+, .*\(")
SPILL = re.compile(r"\tv.*\(%rsp\)|\t(?:ld|st).*\bq\d.*\[sp")


def unoptimized():
    """LLVM's intermediate representation of the planar predictor, all functions in one."""
    import numba

    from evidence.benchmarks.kernel_speed import planar
    from hpcrub.contact import passes
    from hpcrub.contact.bank import allocate
    from hpcrub.contact.lanes import WIDTH
    from hpcrub.response.revolution import cut_revolution

    modes, scene = planar()
    bank = allocate(modes, scene, cut_revolution(34.0, scene), WIDTH)
    passes.predict.compile(
        (numba.typeof((0,) * WIDTH), numba.typeof(bank), numba.int64, numba.int64)
    )
    (compiled,) = passes.predict.overloads.values()
    return compiled.library.get_llvm_str()


def assembly(text, triple, processor):
    """Assembly of a program in LLVM's intermediate representation, optimized for a machine."""
    from llvmlite import binding

    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    target = binding.Target.from_triple(triple).create_target_machine(processor, "", opt=3)
    lines = (line for line in text.splitlines() if not line.startswith("target "))
    module = binding.parse_assembly("\n".join(lines))
    module.triple, module.data_layout = triple, str(target.target_data)
    options = binding.create_pipeline_tuning_options(speed_level=3)
    builder = binding.create_pass_builder(target, options)
    builder.getModulePassManager().run(module, builder)
    return target.emit_assembly(module)


def loops_of(text):
    """Instructions of every loop, without those of loops inside it."""
    lines, labels, loops = text.splitlines(), {}, set()
    for i, line in enumerate(lines):
        if line.endswith(":"):
            labels[line[:-1]] = i
        elif (jump := JUMP.match(line)) and jump.group(1) in labels:
            loops.add((labels[jump.group(1)], i + 1))
    for begin, end in sorted(loops):
        inside = [(a, b) for a, b in loops if begin <= a and b <= end and (a, b) != (begin, end)]
        own = (i for i in range(begin, end) if not any(a <= i < b for a, b in inside))
        yield [lines[i] for i in own if re.match(r"\t[a-z]", lines[i])]


def count(pattern, loop):
    """Lines of a loop that a pattern matches."""
    return sum(bool(pattern.match(line)) for line in loop)


def rows(name):
    """A row of the table for each loop of the predictor of a disk."""
    registers, vector, triple, processor = MACHINES[name]
    shape = shape_for(Machine(registers, vector, SMALL_CACHE))
    row = shape.lanes // vector  # instructions for a product of all lanes
    loops = list(loops_of(assembly(unoptimized(), triple, processor)))
    sums = [loop for loop in loops if count(FUSED, loop) in (shape.tile * row, 2 * shape.tile * row)
            and not count(PRODUCT, loop) and not count(STORE, loop)]  # fmt: skip
    # four products for a mode of the tile: its corrector and predictor
    modes = min((x for x in loops if count(PRODUCT, x) == 4 * row * shape.tile), key=len)
    parts = {"modal forces": sums[0], "tile of modes": modes, "points": sums[-1]}
    for part, loop in parts.items():
        counts = [count(pattern, loop) for pattern in (FUSED, LOAD, STORE, SPILL)]
        yield [name, f"{shape.tile} × {shape.lanes}", part, len(loop), *counts]


def section():
    """Part of the page: the counts of all machines, each in a process of its shape."""
    found = []
    for name, (registers, vector, *_) in MACHINES.items():
        shape = shape_for(Machine(registers, vector, SMALL_CACHE))
        code = "import json; from evidence.benchmarks.assembly import rows;"
        code += f"print(json.dumps(list(rows({name!r}))))"
        with tempfile.TemporaryDirectory() as folder:
            environment = {"HPCRUB_SHAPE": "x".join(map(str, shape)), "XDG_CACHE_HOME": folder,
                           "NUMBA_OPT": "0", "PYTHONWARNINGS": "ignore"}  # fmt: skip
            said = run(0, "-c", code, env=os.environ | environment, stdout=subprocess.PIPE)
        found += json.loads(said)
    heads = ["machine", "tile × lanes", "loop", "instructions", "fused multiply-adds", "loads",
             "stores", "spills"]  # fmt: skip
    return {"loops": table(heads, found)}
