"""Scenes on a line that come with the package, as the files that describe them."""

from __future__ import annotations

from collections.abc import Mapping

_UNIT = "[material]\nshear_modulus = 1.0\ndensity = 1.0\npoisson_ratio = 0.25\n"
_CRUST = "[material]\nshear_modulus = 32.03812032e9\ndensity = 2670.0\npoisson_ratio = 0.250022\n"

_TAPER = '(1 - tanh(3e3 / min(abs(x) - 18e3, -1e-6) + 3e3 / max(abs(x) - 15e3, 1e-6)))"\n'
_NUCLEATION = """ * exp(x**2 / min(x**2 - 9e6, -1e-3))"
history = "exp((min(t, 1) - 1)**2 / min(min(t, 1) * (min(t, 1) - 2), -1e-12))"
[run]
nodes = 1440
step_ratio = 0.35
every = 20
"""
"""Parts of TPV101 and TPV103: where a rises, and the load over 3 km that comes within a second."""

NAMED_LINES: Mapping[str, str] = {
    "rate-and-state": """
summary = "slow sliding and two events of a fault that weakens with slip rate, in one run of 100 s"
contact = "whole line"
period = 16.0
rate = 1e-6
plate_rate = 1e-6
held = 32.0
even = true
[material]
shear_modulus = 20e9
density = 2222.2222222222222
poisson_ratio = 0.25
[base]
pressure = 5e6
shear = 3e6
[friction_law]
kind = "rate-and-state"
a = 0.010
b = "0.004 + 0.006 * (1 - tanh((abs(x) - 2) / 0.2))"
f0 = 0.6
v0 = 1e-6
distance = 1e-6
theta = "where(abs(x) < 1, 1.3, 1.0)"
[run]
end_time = 100.0
nodes = 256
""",
    "punch": """
summary = "a punch of finite width, under pressure, and shear that arrives from afar"
friction = 0.5
contact = {intervals = [[-1.0, 1.0]]}
period = 16.0
even = true
base = {pressure = 1.0, shear = 0.0}
load = {shear = 0.05, on = "line"}
[run]
end_time = 4.0
nodes = 1024
"""
    + _UNIT,
    "two-slots": """
summary = "two slots whose faces are loaded suddenly: slip from four edges meets"
friction = 0.3
contact = {intervals = [[-inf, -3.0], [-1.0, 1.0], [3.0, inf]]}
period = 24.0
even = true
base = {pressure = 1.0, shear = 0.0}
load = {shear = 1.0, on = "slot"}
[run]
end_time = 3.0
nodes = 1536
"""
    + _UNIT,
    "rock-on-gouge": """
summary = "a growing patch between rock and gouge: slip is faster towards the slip of the gouge"
friction = 0.4
contact = "whole line"
period = 24.0
base = {pressure = 10e6, shear = 3e6}
[material]
shear_modulus = 30e9
density = 2700.0
poisson_ratio = 0.25
[lower_material]
shear_modulus = 12e9
density = 2300.0
poisson_ratio = 0.25
[load]
shear = "2e6 * min(max((600 * t - abs(x)) / 0.1 + 0.5, 0), 1)"
[run]
end_time = 2e-3
nodes = 1024
""",
    "steel-on-rubber": """
summary = "a growing patch between steel and rubber, whose friction follows pressure with a delay"
contact = "whole line"
period = 1.6
base = {pressure = 1e5, shear = 4e4}
[material]
shear_modulus = 80.77e9
density = 7800.0
poisson_ratio = 0.3
[lower_material]
shear_modulus = 3.356e6
density = 1100.0
poisson_ratio = 0.49
[friction_law]
kind = "coulomb"
friction = 0.5
delay = 2e-4
[load]
shear = "2e4 * min(max((20 * t - abs(x)) / 0.006 + 0.5, 0), 1)"
[run]
end_time = 2e-3
nodes = 1024
""",
    "cattaneo": """
summary = "slow shear on a contact under uniform pressure: partial slip of Cattaneo and Mindlin"
friction = 1.0
contact = {intervals = [[-1.0, 1.0]]}
period = 8.0
even = true
base = {pressure = 1.0, shear = 0.0}
[load]
shear = 0.15
on = "line"
history = "min(t / 32, 1)**3 * (10 - 15 * min(t / 32, 1) + 6 * min(t / 32, 1)**2)"
[run]
end_time = 62.0
nodes = 512
step_ratio = 0.5
every = 32
"""
    + _UNIT,
    "supershear": """
summary = "a rupture that weakens with slip and overtakes shear waves (S = 0.8)"
contact = "whole line"
period = 96.0
even = true
base = {pressure = 1.0, shear = 1.0}
[friction_law]
kind = "slip-weakening"
static = 1.8
dynamic = 0.0
distance = 1.3089969389957472
[load]
shear = "0.9 * (abs(x) < min(0.3 * t, 1.5))"
[run]
end_time = 30.0
nodes = 1536
every = 4
"""
    + _UNIT,
    "tpv101": """
summary = "SCEC TPV101 in two dimensions, as UGUCA ran it: rate-and-state, ageing law"
units = "SI"
contact = "whole line"
period = 72e3
rate = 1e-12
even = true
base = {pressure = 120e6, shear = 75e6}
[friction_law]
kind = "rate-and-state"
a = "0.008 + 0.004 * """
    + _TAPER
    + """b = 0.012
f0 = 0.6
v0 = 1e-6
distance = 0.02
[load]
shear = "25e6"""
    + _NUCLEATION
    + "end_time = 15.0\n"
    + _CRUST,
    "tpv103": """
summary = "SCEC TPV103 in two dimensions, as UGUCA ran it: friction that falls at high slip rates"
units = "SI"
contact = "whole line"
period = 72e3
rate = 1e-16
even = true
base = {pressure = 120e6, shear = 40e6}
[friction_law]
kind = "rate-and-state"
a = "0.01 + 0.005 * """
    + _TAPER
    + """b = 0.014
f0 = 0.6
v0 = 1e-6
distance = 0.4
evolution = "slip"
weakened = 0.2
weakening_rate = "0.1 + 0.45 * """
    + _TAPER
    + """[load]
shear = "45e6"""
    + _NUCLEATION
    + "end_time = 12.0\n"
    + _CRUST,
    "tpv205": '''
summary = "SCEC TPV205 in two dimensions: slip weakening with patches of high and low shear"
units = "SI"
contact = "whole line"
period = 96e3
[base]
pressure = 120e6
shear = """
70e6 + 11.6e6 * (abs(x) <= 1.5e3) + 8e6 * (abs(x + 7.5e3) <= 1.5e3)
- 8e6 * (abs(x - 7.5e3) <= 1.5e3)"""
[friction_law]
kind = "slip-weakening"
static = "where(abs(x) <= 15e3, 0.677, 1e4)"
dynamic = 0.525
distance = "where(abs(x) <= 15e3, 0.4, 1e12)"
[run]
end_time = 12.0
nodes = 1920
every = 4
'''
    + _CRUST,
}
"""Descriptions by name, as in TOML files."""

NAMED_SPECIMENS: Mapping[str, str] = {
    "pmma-specimen": """
summary = "plates of PMMA, 200 x 100 mm each, whose left half of the joint loses its shear"
friction = 0.3
gauges = [[0.02, 0.0035], [0.04, 0.0035], [0.06, 0.0035]]
base = {pressure = "5 MPa", shear = "0.8 MPa"}
load = {pressure = 0.0, shear = "0.8 MPa"}
contact = {intervals = [[0.0, 0.1]]}
run = {end_time = 150e-6, size = 1e-3}
[upper]
material = "pmma"
height = 0.1
left = -0.1
right = 0.1
far_side = "clamped"
[lower]
material = "pmma"
height = 0.1
left = -0.1
right = 0.1
far_side = "clamped"
"""
}
"""Specimens of finite size by name, as in TOML files."""
