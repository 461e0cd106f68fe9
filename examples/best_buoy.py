"""The best buoy of a design problem that has been run: its answer, what limits it, and its gradients.

Run `vsb run config/best_buoy.yaml`, then `python -m examples.best_buoy`, or name another folder of results.
"""

import sys

import vsb

folder = sys.argv[1] if len(sys.argv) > 1 else "results/best_buoy"
try:
    found = vsb.open(folder)
except vsb.VsbError as error:
    sys.exit(f"{error}; vsb run config/best_buoy.yaml makes results/best_buoy")
if not isinstance(found, vsb.BestBuoy):
    sys.exit(f"{folder}: holds a study or campaign; needs the results of a design, as results/best_buoy")
print(found.answer)
print(f"gain {found.gain.value:+.2f} % ({found.gain.low:+.2f} to {found.gain.high:+.2f} %)")
for buoy, power in found.power.items():
    print(f"{buoy}: {power:.0f} W")
print(found.starts[["buoy", "accepted", "objective", "kkt", "violation"]].to_string(index=False))
print(found.sensitivity.to_string(index=False))
print(found.optimum.device)
