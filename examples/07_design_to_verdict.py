# %% [markdown]
# # From design to verdict
#
# A badge is designed, printed to files, filmed by a simulated camera, once truly and once forged, and both films are
# judged.  Run this file, or open it as a notebook: each `# %%` begins a cell.

# %%
import sys
from pathlib import Path

import moireid as mo

folder = Path(sys.argv[1] if len(sys.argv) > 1 and "ipykernel" not in sys.modules else "out")

# %% [markdown]
# ## The badge
#
# `badge` alone in a cell shows its picture.  Its identity is given, so that each run is alike; without `payload` one is
# drawn at random, as for a badge to wear.

# %%
badge = mo.design("Ada Lovelace", format="a6", lines=["Reporter"], payload="0123456789abcdef")
print(badge)
badge  # noqa: B018

# %% [markdown]
# ## Its files, and its entry in a registry

# %%
registry = mo.Registry(folder / "people.sqlite3", create=True)
printed = mo.print_badge(badge, folder / "ada", mount="none", registry=registry)
print("written:", ", ".join(sorted(printed.files)))

# %% [markdown]
# ## Two films of it

# %%
shot = {"motion": "sway", "distance_m": 0.6, "frames": 120, "fps": 30, "camera": "webcam", "seed": 1}
true = mo.simulate(badge, folder / "true.mp4", **shot)
forged = mo.simulate(badge, folder / "forged.mp4", forge="frozen", **shot)

# %% [markdown]
# ## Two verdicts

# %%
check = mo.verify(true.video, claim="Ada Lovelace", registry=registry)
print("true:", check)
check  # noqa: B018

# %%
other = mo.verify(forged.video, claim="Ada Lovelace", registry=registry)
print("forged:", other)
print("found:", mo.identify(true.video, registry=registry).found_name)

# %% [markdown]
# ## The fringes: measured, and predicted by optics

# %%
for name, one in (("true", check), ("forged", other)):
    signals = one.signals()
    slope = signals["measured_rad_0"] @ signals["predicted_rad_0"] / (signals["predicted_rad_0"] ** 2).sum()
    print(f"{name}: {len(signals['time_s'])} frames, measured phase is {slope:.2f} times the predicted one")
check.plot().savefig(folder / "true.png")
other.plot()

# %% [markdown]
# ## The report for people

# %%
print("report:", check.write(folder / "report")[0])
registry.close()
