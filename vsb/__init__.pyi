"""The public names, described in docs/api.md: `vsb/__init__.py` reads here where each is, type checkers what it is."""

from vsb.api.best_buoy import BestBuoy as BestBuoy
from vsb.api.buoy import Buoy as Buoy
from vsb.api.buoy import gradient as gradient
from vsb.api.campaign import Campaign as Campaign
from vsb.api.campaign import annual_energy as annual_energy
from vsb.api.campaign import annual_energy_of_series as annual_energy_of_series
from vsb.api.campaign import power_matrix as power_matrix
from vsb.api.results import Results as Results
from vsb.api.results import open as open
from vsb.api.results import run as run
from vsb.engine.hydro.bodies.body import FlexibleBody as FlexibleBody
from vsb.engine.hydro.bodies.solver import BodyProblem as BodyProblem
from vsb.engine.hydro.database import open_database as open_database
from vsb.engine.hydro.dofs import Displacement as Displacement
from vsb.engine.hydro.spectral.solver import SpectralProblem as SpectralProblem
from vsb.engine.integrators.harmonic_balance import harmonic_balance as harmonic_balance
from vsb.engine.integrators.settings import Simulation as Simulation
from vsb.engine.integrators.simulate import simulate as simulate
from vsb.engine.motion.take_off import Pto as Pto
from vsb.engine.shell.deformed import DeformedShell as DeformedShell
from vsb.engine.shell.device import Device as Device
from vsb.engine.shell.modes import ModeBasis as ModeBasis
from vsb.engine.shell.shell import Shell as Shell
from vsb.engine.waves.kinds import Jonswap as Jonswap
from vsb.engine.waves.kinds import RegularWave as RegularWave
from vsb.engine.waves.kinds import StillWater as StillWater
from vsb.engine.waves.water import Water as Water
from vsb.errors import VsbError as VsbError
from vsb.stages.check import read_seas as read_seas
from vsb.study.body import load_body as load_body
from vsb.study.design import load_design as load_design
from vsb.study.sections import Design as Design
from vsb.study.sections import Hydro as Hydro
from vsb.study.sections import Modes as Modes
from vsb.study.study import Study as Study
from vsb.study.study import load as load

__version__: str
