"""First steps: response amplitude operators, and power over a range of dampings, of a rigid and a flexible buoy."""

import numpy as np

import vsb

device = vsb.Device(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0, mass=17170.0)
designs = {"rigid": vsb.Design(flexible=False), "flexible": vsb.Design()}
modes, hydro = vsb.Modes(degree=2), vsb.Hydro(omega_max=4.0, witness="none")
waves = (vsb.RegularWave(kind="regular", amplitude=0.18, period=3.0),)
study = vsb.Study(study="first_steps", device=device, designs=designs, modes=modes, hydro=hydro, waves=waves)
results = vsb.run(study, "results")  # what is there already is kept
omega, dampings = np.array([1.5, 2.0, 2.5, 3.0]), np.array([2e3, 8e3, 32e3])
for design in designs:
    heave = results.response.rao.sel(design=design, dof="Heave").interp(omega=omega)
    print(f"{design}: heave per wave amplitude {np.round(np.abs(heave.values), 3)} at {omega} rad/s")
    for damping, power in zip(dampings, results.port(design, omega).power(dampings), strict=True):
        print(f"  {damping:7.0f} N s/m absorbs {np.round(power / 1e3, 3)} kW/m^2")
print(results.comparison[["design", "power_mean", "damping"]], results.report)
