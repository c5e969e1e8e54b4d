#!/usr/bin/env python3
"""Kills the mapping of a further walk at random moments, and checks that nothing of the home is lost by it.

    bench/kill_joins.py --work /tmp/kills FIRST_WALK SECOND_WALK THIRD_WALK

All walks but the last are mapped into a home. The last one joins a copy of it undisturbed: the reference. Then it joins
copies of it under SIGKILL, at a random moment of the whole run or, every second time, of what comes once all frames are
stored (joining, adjusting, culling, deriving data), until --kills have fallen. After each the home must open, pass
`check` and hold the walks of before; taken up again, and perhaps killed again, it must end as the reference to the bit:
content, derived data, and no file left beside it. From the third walk on a join culls, so give three. Exits with 1 at
the first fault, whose home stays in the folder of work.
"""

import argparse
import hashlib
import json
import random
import shutil
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FRAMES_STORED = "mapping: "  # and " in ": the line that ends the stage


class Fault(Exception):
    """The home is not what it should be."""


class Mapping:
    """A run of `roomwise map`, with the moment at which all its frames were stored."""

    def __init__(self, command):
        self.lines = []
        self.stored = threading.Event()
        self.ended = threading.Event()
        self.began_s = self.stored_s = time.monotonic()
        self.ended_s = None
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.lines.append(line.strip())
            if line.startswith(FRAMES_STORED) and " in " in line:
                self.stored_s = time.monotonic()
                self.stored.set()
        self.ended_s = time.monotonic()
        self.ended.set()
        self.stored.set()  # nobody waits for what will not come

    def wait(self):
        code = self.process.wait()
        self.reader.join()
        return code

    def kill_after(self, wait_s, from_stored):
        """Whether the run was there to be killed."""
        if from_stored:
            self.stored.wait()
        self.ended.wait(wait_s)
        self.process.kill()
        return self.wait() < 0

    def stage(self):
        stages = [line for line in self.lines if ":" in line and not line.startswith("note")]
        return stages[-1] if stages else "begun"


class Bench:
    def __init__(self, options):
        self.options = options
        self.work = Path(options.work)
        self.before = self.work / "before" / "walks.home"
        self.reference = self.work / "reference" / "walks.home"
        self.home = self.work / "killed" / "walks.home"
        self.random = random.Random(options.seed)

    def command(self, walk, home, *more):
        camera = ["--camera", self.options.camera] if self.options.camera else []
        return [self.options.program, "map", walk, "--home", str(home), "--no-networks", "--threads",
                str(self.options.threads), *camera, *more]

    def roomwise(self, *arguments):
        done = subprocess.run([self.options.program, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode != 0:
            raise Fault(f"{arguments[0]} says: {(done.stdout + done.stderr).strip()}")
        return done.stdout

    def info(self, home):
        return json.loads(self.roomwise("info", home, "--json"))

    def copy_to(self, home):
        shutil.rmtree(home.parent, ignore_errors=True)
        home.parent.mkdir(parents=True)
        shutil.copyfile(self.before, home)

    def make_reference(self):
        """The home of the walks before, and how long its last join takes: all of it, and once all frames are stored."""
        shutil.rmtree(self.before.parent, ignore_errors=True)
        self.before.parent.mkdir(parents=True)
        for walk in self.options.walks[:-1]:
            if Mapping(self.command(walk, self.before)).wait() != 0:
                raise SystemExit(f"{walk} cannot be mapped")
        self.copy_to(self.reference)
        mapping = Mapping(self.command(self.options.walks[-1], self.reference))
        if mapping.wait() != 0:
            raise SystemExit(f"{self.options.walks[-1]} cannot be mapped: {mapping.lines}")
        self.take_times(mapping)
        self.expected = self.content(self.reference)
        self.names = [one["name"] for one in self.info(self.before)["recordings"]]

    def take_times(self, mapping):
        """Of a whole run: the machine may have more or less to do than it had."""
        self.whole_s, self.rest_s = mapping.ended_s - mapping.began_s, mapping.ended_s - mapping.stored_s

    def content(self, home):
        """All that must be the same, each part by its name."""
        parts = {"content": json.loads(self.roomwise("info", home, "--digest", "--json"))["content_sha256"]}
        database = sqlite3.connect(f"file:{home}?mode=ro", uri=True)
        for name, made_from, data in database.execute("SELECT name, made_from, data FROM derived_data"):
            parts[f"derived data: {name}"] = f"{made_from} {hashlib.sha256(data).hexdigest()}"
        database.close()
        leftovers = {one.name for one in home.parent.iterdir()} - {home.name + end for end in ("", "-lock", "-shm", "-wal")}
        parts["files beside it"] = " ".join(sorted(leftovers))
        return parts

    def check_killed(self):
        """A home is whole at any moment. Says whether the walk is begun, so that it is to be resumed."""
        self.roomwise("check", self.home)
        recordings = self.info(self.home)["recordings"]
        if [one["name"] for one in recordings[: len(self.names)]] != self.names:
            raise Fault(f"its walks are {[one['name'] for one in recordings]}; {self.names} were there before")
        if not all(one["finished"] for one in recordings[: len(self.names)]):
            raise Fault("a walk of before is no longer finished")
        return recordings[len(self.names) :]

    def run_until(self, begun):
        """One run of the map, killed or not; whether it was killed."""
        resume = ["--resume"] if begun and begun[0]["frames"] > 0 else []
        mapping = Mapping(self.command(self.options.walks[-1], self.home, *resume))
        # Once it was killed, it may be again: every third time.
        wanted = self.kills < self.options.kills and (not self.trail or self.random.random() < 1 / 3)
        share, late = self.random.random(), self.kills % 2 == 1
        if wanted and mapping.kill_after(share * (self.rest_s if late else self.whole_s), late):
            self.kills += 1
            self.trail.append(mapping.stage())
            return True
        if (code := mapping.wait()) != 0:
            raise Fault(f"map ended with {code}: {' | '.join(mapping.lines[-3:])}")
        if not resume:
            self.take_times(mapping)
        return False

    def one_join(self):
        self.copy_to(self.home)
        self.trail = []
        begun = []
        while self.run_until(begun):
            begun = self.check_killed()
            if begun and begun[0]["finished"]:
                break  # killed in the moment after the last
        content = self.content(self.home)
        for part in self.expected.keys() | content.keys():
            if self.expected.get(part) != content.get(part):
                raise Fault(f"{part}: {content.get(part)} where the reference has {self.expected.get(part)}")

    def run(self):
        self.make_reference()
        print(f"an undisturbed join takes {self.whole_s:.1f} s, {self.rest_s:.1f} s of it once all frames are stored", flush=True)
        self.kills, joins, faults = 0, 0, 0
        stages = {}
        while self.kills < self.options.kills and not faults:
            try:
                self.one_join()
            except Fault as fault:
                faults += 1
                print(f"FAULT after kills at [{'; '.join(self.trail)}]: {fault}; the home is {self.home}")
            joins += bool(self.trail)
            print(f"{self.kills} kills; this home at [{'; '.join(self.trail)}]", file=sys.stderr, flush=True)
            for stage in self.trail:
                name = stage.split(":")[0]
                stages[name] = stages.get(name, 0) + 1
        print(json.dumps({"kills": self.kills, "joins": joins, "faults": faults, "last line before the kill": stages,
                          "seed": self.options.seed}), flush=True)
        return 0 if faults == 0 else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("walks", metavar="WALK", nargs="+", help="recordings of one home; the last one's join is killed")
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/roomwise"))
    parser.add_argument("--work", required=True, help="folder to work in; its before, reference and killed are written anew")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1, help="of the moments; what a moment meets depends on the machine")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--camera", help="camera of the walks' pictures, as roomwise map takes it")
    options = parser.parse_args()
    if len(options.walks) < 2:
        parser.error("give two walks or more")
    return Bench(options).run()


if __name__ == "__main__":
    sys.exit(main())
