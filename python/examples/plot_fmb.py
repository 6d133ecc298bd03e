"""Builds the flexible multi-beam frame of Hesse & Palacios (2012), runs its load case 2 and plots what happens.

    python plot_fmb.py [OUT.png]
"""

import pathlib
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import romgen

MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"


def main(out):
    model = romgen.build(MODELS / "fmb.toml", modes=10)
    runs = {
        "10 elastic modes": romgen.run(model, "lc2"),
        "rigid": romgen.run(model.with_method("rigid"), "lc2"),
    }
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), layout="constrained")
    figure.suptitle(f"{model.name}, load case lc2, {model.mass:.0f} kg, lowest mode {model.omega[0]:.2f} rad/s")
    for (name, run), style in zip(runs.items(), ["-", "--"]):
        for i, axis in enumerate("xyz"):
            color = f"C{i}"
            axes[0, 0].plot(run["t"], run["w_G"][:, i], style, color=color, label=f"{axis}, {name}")
            axes[0, 1].plot(run["t"], run["v_G"][:, i], style, color=color)
            if name != "rigid":
                axes[1, 0].plot(run["t"], run["P.dR_A"][:, i], color=color)
        axes[1, 1].plot(run["P.R_G"][:, 0], run["P.R_G"][:, 2], style, color="C3", label=f"P, {name}")
        axes[1, 1].plot(run["r_G"][:, 0], run["r_G"][:, 2], style, color="C4", label=f"A, {name}")
    titles = [
        "angular velocity of A in G (rad/s)",
        "velocity of A in G (m/s)",
        "displacement of tip P in A (m)",
        "paths in the x-z plane of G (m)",
    ]
    for ax, title in zip(axes.flat, titles):
        ax.set_title(title, fontsize=10)
        ax.grid(alpha=0.3)
        ax.set_xlabel("x (m)" if "paths" in title else "t (s)")
    axes[0, 0].legend(fontsize=7, ncols=2)
    axes[1, 1].legend(fontsize=7)
    axes[1, 1].set_aspect("equal", "datalim")
    figure.savefig(out, dpi=110)
    peak = np.abs(runs["10 elastic modes"]["P.dR_A"]).max(axis=0)
    print(f"farthest displacement of P: {peak.round(3)} m; wrote {out}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "fmb-lc2.png")
