"""Break the code in 66 places, one after the other, and see whether the quick tests notice.

python studies/mutants.py                    all of them, each with its nearest tests: half an hour
python studies/mutants.py firmware robot:    those whose names begin so
python studies/mutants.py --whole NAME       where the nearest tests let it live, all quick tests
python studies/mutants.py --write            keep the list of those that died, mutants_killed.txt

mutants.toml has them: `old` stands once in `file` and becomes `new`. Where code was rewritten so
that `old` is gone, this script and tests/studies/test_mutants.py say so. Then look for the code
that keeps the same promise now, and break that: the name says which promise. Take the shortest text
that is unique; line numbers and formatting do not count beyond it. If the promise itself is gone,
put another mutant of the same room in its place. Then run it: `mutants.py NAME --write`.

The tree is changed while a mutant runs, and put back after it, also by Ctrl-C. A test that fails on
the tree as it is counts for nothing: all that killed a mutant are run again at the end.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
MUTANTS, KILLED = (Path(__file__).with_name(f"mutants{end}") for end in (".toml", "_killed.txt"))
LONGEST_S = 900.0  # for the tests of a mutant: beyond it hangs, which a person would notice
FAILED = re.compile(r"^(?:FAILED|ERROR) ([^\s:]+(?:::\w+)*)", re.M)


@dataclass(frozen=True)
class Mutant:
    """A change of the code that some test must notice."""

    name: str
    file: str
    old: str
    new: str
    tests: list[str]

    @property
    def path(self) -> Path:
        """Return its file."""
        return ROOT / self.file

    def objection(self) -> str:
        """Return why it no longer applies, or nothing."""
        if not self.path.exists():
            return f"{self.name}: {self.file} is gone"
        times = self.path.read_text().count(self.old)
        missing = [test for test in self.tests if not (ROOT / test.split("::")[0]).exists()]
        if times != 1:
            return f"{self.name}: {self.old!r} stands {times} times in {self.file}, not once"
        return f"{self.name}: there is no {', '.join(missing)}" if missing else ""


def mutants() -> list[Mutant]:
    """Return all mutants."""
    return [Mutant(**row) for row in tomllib.loads(MUTANTS.read_text())["mutant"]]


def killed() -> list[str]:
    """Return the names of those that died when they were last run."""
    return KILLED.read_text().splitlines() if KILLED.exists() else []


def build() -> None:
    """Compile what changed; raises SystemExit where that fails."""
    done = subprocess.run(["make", "build"], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"this does not build:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


@contextmanager
def broken(mutant: Mutant) -> Iterator[None]:
    """Change the tree for a while."""
    text = mutant.path.read_text()
    try:
        mutant.path.write_text(text.replace(mutant.old, mutant.new))
        build()  # also where this mutant is Python: the one before it may have been C++
        yield
    finally:
        mutant.path.write_text(text)


def first_failure(tests: list[str]) -> str:
    """Return the first quick test that fails; nothing where all pass."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "-m", "not slow", *tests]
    try:
        done = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=LONGEST_S
        )
    except subprocess.TimeoutExpired:
        return "hangs"
    if done.returncode < 0:
        return "crashes"
    if done.returncode not in (0, 1, 2):
        raise SystemExit(f"{' '.join(command)}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    failed = FAILED.search(done.stdout)
    return failed[1] if failed else "" if done.returncode == 0 else "cannot be collected"


def run(chosen: list[Mutant], all_tests: bool) -> dict[str, str]:
    """Break the tree by each mutant; return which test noticed, nothing for those that live."""
    noticed = {}
    for mutant in chosen:
        begin = time.monotonic()
        with broken(mutant):
            test = first_failure(mutant.tests) or (first_failure(["tests"]) if all_tests else "")
        noticed[mutant.name] = test
        print(f"{mutant.name}: {test or 'LIVES'} ({time.monotonic() - begin:.0f} s)", flush=True)
    build()
    return noticed


def main() -> int:
    """Run mutants; exit status 1 where one of them lives that died before."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="how names begin")
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    chosen = [m for m in mutants() if m.name.startswith(tuple(arguments.names) or "")]
    objections = list(filter(None, (mutant.objection() for mutant in chosen)))
    if objections:
        raise SystemExit("\n".join(objections))
    noticed = run(chosen, arguments.whole)
    tests = sorted({test for test in noticed.values() if ".py" in test})
    while tests and (wrong := first_failure(tests)):
        print(f"{wrong} fails without any mutant: it counts for nothing")
        tests.remove(wrong)
        noticed = {name: "" if test == wrong else test for name, test in noticed.items()}
    died = {name for name, test in noticed.items() if test}
    killed_before = set(killed())
    print(f"{len(died)} of {len(noticed)} died")
    if arguments.write:
        names = [m.name for m in mutants() if m.name in (killed_before - noticed.keys()) | died]
        KILLED.write_text("".join(f"{name}\n" for name in names))
    risen = sorted((killed_before & noticed.keys()) - died)
    print("".join(f"lives, and died before: {name}\n" for name in risen), end="")
    return int(bool(risen))


if __name__ == "__main__":
    sys.exit(main())
