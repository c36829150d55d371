# %% [markdown]
# # Measure your own sheet
#
# A lens sheet's pitch and thickness are seldom those of its label.  Print the pitch test, lay the sheet on it, and film
# it: the bands show the pitch, and the motion of their fringes the thickness.  Here a simulated camera films a sheet of
# 50 lenses to the inch that is 0.2 % too wide and 10 % too thin.

# %%
import sys
from pathlib import Path

import moireid as mo
from moireid.calibration.sheet_reading import read_sheet
from moireid.designer import design_chart
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.profiles import save_profile

folder = Path(sys.argv[1] if len(sys.argv) > 1 and "ipykernel" not in sys.modules else "out")
folder.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The chart

# %%
chart = design_chart(lens="50lpi")
write_badge_pdf(chart, folder / "pitch_test.pdf")
print(chart)

# %% [markdown]
# ## A film of it
#
# In place of this line, film the printed chart under your sheet, moving the camera sideways.

# %%
film = mo.simulate(
    chart,
    folder / "chart.mp4",
    motion="linear",
    distance_m=1.0,
    frames=90,
    fps=30,
    build="ideal",
    flaws=["lens-scale=1.002", "thickness=0.9"],
).video

# %% [markdown]
# ## What the film shows

# %%
found = read_sheet(film, chart, distance_m=1.0)
sheet = found.profile
built = 1.002 * chart.lens.pitch_mm
print(f"pitch {sheet.lens.pitch_mm:.4f} mm ± {1000 * sheet.pitch_sd_mm:.2f} um; built {built:.4f} mm")
print(f"thickness {sheet.lens.thickness_mm:.2f} mm; built {0.9 * chart.lens.thickness_mm:.2f} mm")

# %% [markdown]
# ## A badge for this very sheet

# %%
save_profile(sheet, folder / "my_sheet.json")
badge = mo.design("Ada Lovelace", lens=folder / "my_sheet.json")
print(badge)
badge  # noqa: B018
