#!/usr/bin/env python3
"""Predicted against measured errors over the load cases of the models: how well each method knows its own error.

usage: validity.py ROMGEN [--quick]

For every run of a reduced method against the nonlinear structure: the measured errors of v_G, w_G and the displacements, what the run
itself estimated, and the ratio of the two. Then, method by method, in how many runs the estimate is within a factor 2 and 4 of the
truth or both are below a limit that nobody cares about, the worst ratios, and the rank correlation. Tables are in Markdown.
"""

import json
import subprocess
import sys

# What is below this, measured and predicted, is not told apart: two methods differ by as much at the time steps of the load cases (FMB lc2 at
# sigma = 300: 0.04 % at 0.02 s, 0.01 % at 0.005 s).
NOTHING = 5e-4

# name, arguments of `romgen validate`, whether it is short
STUDIES = [
    ("FMB", ["models/fmb.toml", "--loads", "lc2", "--sweep", "sigma=3,5,10,30,100,300,1000"], True),
    ("FMB", ["models/fmb.toml", "--loads", "lc1", "--t-end", "20", "--sweep", "sigma=10,30,100"], False),
    ("FMB", ["models/fmb.toml", "--loads", "spiral", "--sweep", "sigma=6,10,30,100"], False),
    ("FFB", ["models/ffb.toml", "--loads", "planar"], False),
    ("hale", ["models/hale.toml", "--loads", "gust,elevator"], False),
    ("joined wing", ["models/joined_wing.toml", "--loads", "joints"], False),
    ("curved blade", ["models/curved_blade.toml", "--loads", "flick"], False),
]
METHODS = "nonlinear,rom,mean-axes,rigid"
GEOMETRIC = ["--inertia", "consistent", "--elastic", "geometric"]
QUANTITIES = ["v_G", "w_G", "dR_A"]


def rows_of(romgen, arguments):
    """Rows of one study; some methods may have failed in it, which it says with exit code 3."""
    run = subprocess.run([romgen, "validate", *arguments, "--json", "-", "--quiet"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if run.returncode not in (0, 3) or not run.stdout.strip():
        print(f"  not run (exit code {run.returncode}): {run.stderr.strip()[:200]}", flush=True)
        return []
    return json.loads(run.stdout)


def measured(row):
    """Measured errors of v_G, w_G and the worst of the points that move at least a tenth as far as the farthest, as they are predicted."""
    return [row["errors"].get("v_G"), row["errors"].get("w_G"), row.get("worst_dR_A")]


def percent(x):
    return "-" if x is None else f"{100 * x:.3g} %"


def ranks(values):
    order = sorted(range(len(values)), key=values.__getitem__)
    out = [0.0] * len(values)
    for rank, index in enumerate(order):
        out[index] = float(rank)
    return out


def rank_correlation(pairs):
    """Spearman's."""
    if len(pairs) < 3:
        return float("nan")
    a, b = (ranks([pair[k] for pair in pairs]) for k in (0, 1))
    mean = (len(pairs) - 1) / 2
    covariance = sum((x - mean) * (y - mean) for x, y in zip(a, b))
    return covariance / sum((x - mean) ** 2 for x in a)


def main():
    romgen, quick = sys.argv[1], "--quick" in sys.argv[2:]
    found = {}
    print("| case | method | measured v_G, w_G, dR_A | predicted | predicted / measured |\n| --- | --- | --- | --- | --- |", flush=True)
    for name, arguments, short in STUDIES:
        if quick and not short:
            continue
        for family, extra in [("", ["--method", METHODS]), ("geometric ", ["--method", "nonlinear,rom", *GEOMETRIC])]:
            for row in rows_of(romgen, [*arguments, *extra]):
                method = family + row["method"]
                place = ", ".join([f"{name} {row['loads']}", *(f"{k} = {v:g}" for k, v in row["set"].items() if k == "sigma")])
                if row.get("failure") or not row.get("predicted"):
                    print(f"| {place} | {method} | {(row.get('failure') or 'no estimate')[:120]} | | |", flush=True)
                    continue
                true, told = measured(row), [row["predicted"][key] for key in QUANTITIES]
                ratios = []
                for quantity, t, p in zip(QUANTITIES, true, told):
                    if t is None or p is None:
                        ratios.append("-")
                        continue
                    found.setdefault((method, quantity), []).append((t, p))
                    ratios.append("both below 0.05 %" if max(t, p) < NOTHING else f"{p / t:.2g}")
                print(f"| {place} | {method} | {', '.join(map(percent, true))} | {', '.join(map(percent, told))} | {', '.join(ratios)} |", flush=True)
    print("\n| method | quantity | runs | within 2 | within 4 | lowest, highest ratio | rank correlation |\n| --- | --- | --- | --- | --- | --- | --- |")
    for (method, quantity), pairs in sorted(found.items()):
        factors = [1.0 if max(t, p) < NOTHING else p / max(t, 1e-12) for t, p in pairs]
        within = lambda limit: sum(1 / limit <= f <= limit for f in factors)
        correlation = rank_correlation(pairs)
        print(f"| {method} | {quantity} | {len(pairs)} | {within(2)} | {within(4)} | {min(factors):.2g}, {max(factors):.2g} | {correlation:.2f} |")


if __name__ == "__main__":
    main()
