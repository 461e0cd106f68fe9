"""The buoy that absorbs most in a site's year, found from Python: its answer, proof, limits, and a study of it.

`python -m examples.best_buoy` solves config/best_buoy.yaml in some minutes; another design file may be named, as
`vsb init my_design.yaml --design` writes one. What is in results/ already is kept.
"""

import sys

import vsb

try:
    found = vsb.run(vsb.load_design(sys.argv[1] if len(sys.argv) > 1 else "config/best_buoy.yaml"))
except vsb.VsbError as error:
    sys.exit(str(error))
print(found.answer)
print(f"gain {found.gain.value:+.2f} % ({found.gain.low:+.2f} to {found.gain.high:+.2f} %)")
for buoy, power in found.power.items():
    print(f"{buoy}: {power:.0f} W")
print(found.starts[["buoy", "accepted", "objective", "kkt", "violation"]].to_string(index=False))
print(found.sensitivity.to_string(index=False))
print(found.optimum.device)
print(found.report)
