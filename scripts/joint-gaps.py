#!/usr/bin/env python3
"""How far joints open: many runs that differ a little, since one run is chance. Prints geometric mean and greatest gap, mm.

    python3 scripts/joint-gaps.py nets                                   24 nets, hung and loaded in eight ways
    python3 scripts/joint-gaps.py ragdolls --set solver.jointed.passes=2  24 heaps of 120, whose steps differ by .03 %
    … --runs 96   more heaps        … --dt 0.0333   other steps        … --steps 1500   longer

Builds the release program first; `ISHIGAKI` names another one.
"""
import argparse, json, math, os, subprocess, sys, tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def net(program, kind, n):
    """A net of n × n balls, 1 m apart, by way of `ishigaki scenes joint_grid`."""
    scene = json.loads(subprocess.check_output([program, "scenes", "joint_grid", "--param", f"n={n}"]))
    bodies, joints = scene["bodies"], scene["joints"]
    at = lambda row, column: row * n + column
    corners = [at(0, 0), at(0, n - 1), at(n - 1, 0), at(n - 1, n - 1)]
    if kind.startswith("corners"):
        held = corners[: int(kind[-1])]
        for index, body in enumerate(bodies):
            body.pop("kind", None)
            if index in held:
                body["kind"] = "fixed"
        for c in (c for c in range(n - 1) if not (c in held and c + 1 in held)):
            frame = {"world": {"position": [c - 0.5 * (n - 1) + 0.5, 0, 0]}}
            joints.append({"body_a": c, "body_b": c + 1, "kind": {"ball": {}}, "frame": frame})
    shapes = [body["shapes"][0] for body in bodies]
    if kind == "loaded":
        for c in range(n):
            bodies[at(n - 1, c)]["kind"] = "fixed"
        for shape in shapes:
            shape["member_of"], shape["collides_with"] = 1, 4
        ball = {"geometry": {"ball": {"radius": 2.0}}, "member_of": 4, "collides_with": 1}
        bodies.append({"position": [0, 5, 0.5 * n], "shapes": [ball]})
    if kind == "heavy hem":
        for c in range(n):
            shapes[at(n - 1, c)]["density"] = 20000
    if kind == "boxes":
        for shape in shapes:
            shape["geometry"] = {"cuboid": {"half_extents": [0.4, 0.1, 0.3]}}
    if kind == "draped":
        for shape in shapes:
            shape["member_of"], shape["collides_with"] = 1, 1
        bodies.append({"kind": "fixed", "position": [0, -8, 0.7 * n], "shapes": [{"geometry": {"ball": {"radius": 5}}}]})
    return scene


NETS = ["edge", "corners 1", "corners 2", "corners 4", "loaded", "heavy hem", "boxes", "draped"]


def run(program, arguments):
    """Greatest gap, mm, and work over the budget."""
    done = subprocess.run([program, "run", *arguments, "--json", "--quiet"], capture_output=True, text=True)
    if done.returncode != 0 and not done.stdout:
        sys.exit(f"joint-gaps: {' '.join(arguments)}: {done.stderr.strip()}")
    result = json.loads(done.stdout)
    gap = result["worst_joint_error"]
    lost = result["non_finite"] or gap is None
    return (math.inf if lost else 1e3 * max(gap, 1e-5)), result["work_over_budget"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["nets", "ragdolls"])
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--runs", type=int, default=24)
    parser.add_argument("--steps", type=int)
    parser.add_argument("--dt", type=float, default=1 / 60)
    asked = parser.parse_args()
    program = os.environ.get("ISHIGAKI")
    if not program:
        subprocess.check_call(["cargo", "build", "--release", "--quiet", "--package", "ishigaki-cli"], cwd=ROOT)
        target = os.environ.get("CARGO_TARGET_DIR", "target")
        program = os.path.join(ROOT, target, "release", "ishigaki")
    options = [word for setting in asked.set for word in ("--set", setting)]
    seen = []
    with tempfile.TemporaryDirectory() as folder:
        if asked.what == "nets":
            cases = [(f"{kind}, {n} × {n}", kind, n) for kind in NETS for n in (10, 20, 30)]
        else:
            cases = [(f"Δt × {1 + 3e-4 * k:.4f}", None, k) for k in range(asked.runs)]
        for name, kind, number in cases:
            if kind:
                scene, dt = [os.path.join(folder, "net.json")], asked.dt
                with open(scene[0], "w") as file:
                    json.dump(net(program, kind, number), file)
            else:
                scene, dt = ["ragdolls", "--param", "n=120"], asked.dt * (1 + 3e-4 * number)
            steps = asked.steps or (400 if kind else 300)
            gap, work = run(program, [*scene, "--steps", str(steps), "--dt", f"{dt:.8f}", *options])
            seen.append((gap, work))
            print(f"{name}: {gap:.1f} mm, work {work:.2f}", file=sys.stderr)
    kept = [gap for gap, _ in seen if gap < math.inf]
    mean = math.exp(sum(map(math.log, kept)) / len(kept)) if kept else math.inf
    work = sum(work for _, work in seen) / len(seen)
    lost = f", {len(seen) - len(kept)} not finite" if len(kept) < len(seen) else ""
    print(f"{len(seen)} runs: {mean:.1f} mm, at most {max(kept, default=math.inf):.1f}{lost}; work {work:.2f}")


main()
