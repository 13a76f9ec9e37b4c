#!/usr/bin/env python3
# test: wrong input is refused in one line
"""Wrong input must be refused in one plain line, and a run that is stopped must leave its result.

    bad_input.py build/tendril [--mpiexec mpiexec] [--only WORD] [--verbose]

Every case: exit code not 0; exactly one line on stderr, which starts with "tendril: " and names the
option (or the time); no traceback. Needs h5py for the cases with HDF5 input of its own making and
for reading what a killed run left; takes .venv's python if this one has none."""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from math import cos, sin
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from held import HANG, PAGE, Held
from interpreter import from_venv

try:
    import h5py
except ImportError as error:
    from_venv(error)

SHORT = "-output out.h5 -rod_cells 20 -ts_max_time 1e-3".split()

SOUND = [
    "-growth_type table -growth_table table",
    "-options_file sound_opts -friction_mu 0.5",
    "-options_file scene/marked_opts",
    "-ts_type beuler -ts_adapt_type none -ts_dt 1e-4",
    "-clamp_angle -0.5 -shape_amplitude -1e-3",
    "-clamp_angle 90deg",
    "-friction_field field -tip_force 1 -tip_law resistance -tip_field field_across",
    "-friction_layers 0:1,3:2 -friction_layer_width 0.2 -rod_stiffness_file stiffness",
    "-wall_file wall_sound -contact_diameter 0.1 -contact_friction 0.3 -contact_self",
    "-wall_file wall_own -contact_diameter 0.1 -contact_friction 0.3 -contact_self",
    "-wall_file wall_metres -si_bending_stiffness 1e-4 -si_friction_dry 20 -si_speed 1e-3",
    "-wall_file wall_shapes_sound -contact_diameter 0.3",
    "-wall_file wall_moves_sound -contact_diameter 0.1",
    "-wall_file wall_moves_sound_files -contact_diameter 0.1 -si_bending_stiffness 1e-4 -si_friction_dry 20 -si_speed 1e-3",
    "-snes_view -ksp_converged_reason -options_view -ts_view",
    "",
]

# (command line after SHORT, what the line must contain). {X} are the files made below.
CASES = [
    # out of range
    ("-friction_mu 1.5", "-friction_mu"),
    ("-friction_mu -0.1", "-friction_mu"),
    ("-friction_beta -1e-3", "-friction_beta"),
    ("-growth_initial_length 0", "-growth_initial_length"),
    ("-growth_initial_length -2", "-growth_initial_length"),
    ("-growth_type gaussian -growth_width 0", "-growth_width"),
    ("-rod_cells 0", "-rod_cells"),
    ("-rod_cells 3", "-rod_cells"),
    ("-rod_cells -100", "-rod_cells"),
    ("-rod_cells 99999999999", "-rod_cells"),
    ("-rod_cells 20000000", "-rod_cells"),
    ("-rod_cells 16000000", "-rod_cells"),
    ("-rod_order 3", "-rod_order"),
    ("-ts_max_time -1", "-ts_max_time"),
    ("-ts_max_time 0", "-ts_max_time"),
    ("-ts_rtol 0", "-ts_rtol"),
    ("-ts_rtol -1e-6", "-ts_rtol"),
    ("-ts_rtol 1e-20", "-ts_rtol"),
    ("-ts_dt 0", "-ts_dt"),
    ("-ts_bdf_order 9", "-ts_bdf_order"),
    ("-ts_bdf_order 0", "-ts_bdf_order"),
    ("-output_interval 0", "-output_interval"),
    ("-output_interval -1", "-output_interval"),
    ("-shape_amplitude 100", "-shape_amplitude"),
    ("-shape_type random -shape_seed -1", "-shape_seed"),
    # no number, or another kind of number
    ("-friction_mu dry", "-friction_mu"),
    ("-friction_mu nan", "-friction_mu"),
    ("-friction_mu 0.5.1", "-friction_mu"),
    ("-friction_mu=0.5", "put a blank before the value: -friction_mu 0.5"),
    ("-friction_mu 0,5", "-friction_mu"),
    ("-friction_mu", "-friction_mu"),
    ("-friction_beta 1e-3x", "-friction_beta"),
    ("-clamp_angle inf", "-clamp_angle"),
    ("-clamp_type loose", "-clamp_type"),
    ("-rod_stiffness 2", "-rod_stiffness: is of one of several rods"),
    ("-clamp_on a", "-clamp_on: is of one of several rods"),
    ("-clamp_type free -growth_type feed", "-clamp_type free: rods that are fed in"),
    ("-clamp_type free -rod_model mixed", "-clamp_type: the mixed model's rod"),
    ("-clamp_type free -rod_model space", "-friction_radius"),
    ("-clamp_type free -clamp_spin 1", "-clamp_spin"),
    ("-clamp_type free -task critical", "-clamp_type free: -task critical"),
    ("-clamp_type hinged -friction_radius 0.1", "-friction_radius: a rod that tilts"),
    ("-clamp_type hinged -growth_type feed", "-clamp_type hinged: rods that are fed in"),
    ("-clamp_type hinged -tip_type pinned -rod_order 2", "-rod_order 2: the first cell"),
    ("-clamp_type hinged -rod_model linear", "-clamp_type: the linear model's rod"),
    ("-clamp_type hinged -task critical", "-clamp_type hinged: -task critical"),
    ("-clamp_type hinged -tip_type pinned -task stability", "-tip_type: -task stability"),
    ("-clamp_type hinged -tip_type pinned -shape_type mode", "-shape_type mode: begins tilted in a hinge"),
    ("-clamp_type hinged -tip_type pinned -rod_curvature 1 -task critical -rod_model space", "-clamp_type: -task critical"),
    ("-clamp_angle 90", "-clamp_angle"),
    ("-clamp_angle 90m", "-clamp_angle"),
    ("-stop_length 28cm", "-stop_length"),
    ("-rod_cells 12.5", "-rod_cells"),
    ("-rod_cells many", "-rod_cells"),
    ("-ts_max_time inf", "-ts_max_time"),
    ("-ts_max_time nan", "-ts_max_time"),
    ("-ts_rtol tight", "-ts_rtol"),
    ("-ts_dt 0.01s", "-ts_dt"),
    ("-ts_init_time 1", "-ts_init_time"),
    ("-ts_bdf_order two", "-ts_bdf_order"),
    ("-ts_bdf_factor 4", "-ts_bdf_factor"),
    ("-ts_max_steps lots", "-ts_max_steps"),
    ("-output_interval often", "-output_interval"),
    ("-snes_max_it many", "-snes_max_it"),
    ("-snes_atol x", "-snes_atol"),
    ("-ts_adapt_dt_max big", "-ts_adapt_dt_max"),
    ("-quiet perhaps", "-quiet"),
    # not a word of the list
    ("-task nonsense", "-task"),
    ("-growth_type exponential", "-growth_type"),
    ("-growth_type Uniform", "-growth_type"),
    ("-growth_type", "-growth_type"),
    ("-friction_newton dual", "-friction_newton"),
    ("-shape_type bent", "-shape_type"),
    ("-rod_model beam", "-rod_model"),
    ("-rod_grading fine", "-rod_grading"),
    ("-ts_type nonsense", "-ts_type"),
    ("-ts_type euler", "-ts_type"),
    ("-ts_type rosw", "-ts_type"),
    ("-ts_type arkimex", "-ts_type"),
    ("-ts_adapt_type nonsense", "-ts_adapt_type"),
    ("-ts_adapt_type dsp", "-ts_adapt_type"),  # which vbdf would ignore
    ("-ts_adapt_type glee", "-ts_adapt_type"),
    ("-ts_adapt_dt_min 1e-3", "-ts_adapt_dt_min"),
    ("-ts_adapt_safety 0.5", "-ts_adapt_safety"),
    ("-ts_adapt_clip 0.5,2", "-ts_adapt_clip"),
    ("-snes_type nonsense", "-snes_type"),
    ("-ksp_type nonsense", "-ksp_type"),
    ("-pc_type nonsense", "-pc_type"),
    ("-ts_dt_max 1", "-ts_dt_max"),
    # a name nobody knows, or that nothing in this run reads
    ("-friction_nu 1", "-friction_mu"),
    ("-friction_betta 1e-3", "-friction_beta"),
    ("-rod_cell 20", "-rod_cells"),
    ("-ts_maxtime 1", "-ts_max_time"),
    ("-growth_typ gaussian", "-growth_type"),
    ("-xyzzy 1", "-xyzzy"),
    ("-growth_width 0.1", "-growth_width"),
    ("-shape_file {text}", "-shape_file"),
    ("-growth_table {table}", "-growth_table"),
    ("--friction_mu 0.5", "friction_mu"),
    ("friction_mu 0.5", "friction_mu"),
    ("-rod_cells 20 uniform", "uniform"),
    # options files
    ("-options_file {missing}", "-options_file"),
    ("-options_file", "-options_file"),
    ("-options_file {directory}", "-options_file"),
    ("-options_file {unknown_opts}", "-friction_mu"),
    ("-options_file {range_opts}", "-friction_mu"),
    ("-options_file {dashless_opts}", "friction_mu"),
    ("-options_file {result}", "line 1"),
    ("-options_file {two_opts}", "two_opts, line 2: two options on a line"),
    ("-options_file {blank_opts}", "blank_opts, line 3: a blank in the value of -ts_dt"),
    ("-options_file {nul_opts}", "nul_opts, line 2: is not a text file"),
    ("-options_file {wide_opts}", "wide_opts, line 1: is not a text file"),
    ("-options_file {number_opts}", "number_opts, line 1"),
    ("-options_file {dashes_opts}", "one dash, -friction_mu"),
    ("-options_file {long_opts}", "long_opts, line 1: -shape_file"),
    ("-options_file {self_opts}", "self_opts, line 2: names itself"),
    ("-options_file {one_opts}", "one_opts, line 1: names itself, through another"),
    ("-options_file {pipe}", "-options_file"),
    ("-options_file /dev/zero", "-options_file"),
    ("-options_file {unknown_opts} -options_file {pipe}", "-options_file"),
    ("-output {sound_opts} -options_file {sound_opts}", "-options_file gives"),
    ("{sound_opts}", "-options_file"),
    ("-si_friction_dry 0.5 N/m", "0.5N/m"),
    ("-ts_dt 1,5e-3", "with a point: 1.5e-3"),
    # pipes and devices
    ("-wall_file {pipe}", "-wall_file"),
    ("-wall_file /dev/zero", "-wall_file"),
    ("-friction_field {pipe}", "-friction_field"),
    ("-shape_type file -shape_file {pipe}", "-shape_file"),
    ("-growth_type table -growth_table {pipe}", "-growth_table"),
    ("-rod_stiffness_file {pipe}", "-rod_stiffness_file"),
    ("-restart {pipe}", "-restart"),
    ("-task sweep -sweep_file {pipe}", "-sweep_file"),
    # growth tables
    ("-growth_type table", "-growth_table"),
    ("-growth_type table -growth_table {missing}", "-growth_table"),
    ("-growth_type table -growth_table {text}", "-growth_table"),
    ("-growth_type table -growth_table {empty}", "-growth_table"),
    ("-growth_type table -growth_table {directory}", "-growth_table"),
    ("-growth_type table -growth_table {truncated}", "-growth_table"),
    ("-growth_type table -growth_table {result}", "-growth_table"),
    ("-growth_type table -growth_table {table_turned}", "-growth_table"),
    ("-growth_type table -growth_table {table_flat}", "-growth_table"),
    ("-growth_type table -growth_table {table_nan}", "-growth_table"),
    ("-growth_type table -growth_table {table_negative}", "-growth_table"),
    ("-growth_type table -growth_table {table_half}", "-growth_table"),
    ("-growth_type table -growth_table {table_unsorted}", "-growth_table"),
    ("-growth_type table -growth_table {table_few}", "-growth_table"),
    ("-growth_type table -growth_table {table_late}", "-growth_table"),
    ("-growth_type table -growth_table {table_words}", "-growth_table"),
    ("-growth_type table -growth_table {table} -ts_max_time 2.5", "-ts_max_time"),
    # shapes
    ("-shape_type file", "-shape_file"),
    ("-shape_type file -shape_file {missing}", "-shape_file"),
    ("-shape_type file -shape_file {truncated}", "-shape_file"),
    ("-shape_type file -shape_file {shape_lengths}", "-shape_file"),
    ("-shape_type file -shape_file {shape_turned}", "-shape_file"),
    # natural curvature
    ("-rod_curvature 1e10", "-rod_curvature"),
    ("-rod_curvature bent", "-rod_curvature"),
    ("-rod_curvature 0.1 -rod_model linear", "-rod_curvature"),
    ("-rod_curvature 0.1 -task critical", "-rod_curvature"),
    ("-rod_curvature_random -1", "-rod_curvature_random"),
    ("-rod_curvature_random 0.1 -rod_curvature_length 0", "-rod_curvature_length"),
    ("-rod_curvature_random 0.1 -rod_curvature_seed -1", "-rod_curvature_seed"),
    ("-rod_curvature_seed 3", "-rod_curvature_seed"),
    ("-rod_curvature_file {missing}", "-rod_curvature_file"),
    ("-rod_curvature_file {text}", "-rod_curvature_file"),
    ("-rod_curvature_file {shape_lengths}", "-rod_curvature_file"),
    ("-rod_curvature_file {curvature_nan}", "-rod_curvature_file"),
    # friction that varies
    ("-friction_across 0", "-friction_across"),
    ("-friction_across -1", "-friction_across"),
    ("-friction_field {missing}", "-friction_field"),
    ("-friction_field {text}", "-friction_field"),
    ("-friction_field {table}", "-friction_field"),
    ("-friction_field {field_negative}", "-friction_field"),
    ("-friction_field {field_dips}", "-friction_field"),
    ("-friction_field {field_nan}", "-friction_field"),
    ("-friction_field {field_unsorted}", "-friction_field"),
    ("-friction_field {field_turned}", "-friction_field"),
    ("-friction_field {field_no_factor}", "-friction_field"),
    ("-friction_field {field} -friction_layers 0:1", "-friction_layers"),
    ("-friction_layers 0:1,3:2,2:1", "-friction_layers"),
    ("-friction_layers 0:1,3:-2", "-friction_layers"),
    ("-friction_layers 0:1,3", "-friction_layers"),
    ("-friction_layers 0:1,", "-friction_layers"),
    ("-friction_layers 0:nan", "-friction_layers"),
    ("-friction_layers 0:1,1:2,1.05:3", "-friction_layer"),
    ("-friction_layers 0:1 -friction_layer_width 0", "-friction_layer_width"),
    ("-friction_layer_width 0.2", "-friction_layer_width"),
    ("-friction_field {field_across} -task critical -ts_max_time 5", "-friction_field"),
    ("-friction_field {field_across} -task stability -ts_max_time 5", "-friction_field"),
    # tip
    ("-tip_law follower", "-tip_law"),
    ("-tip_law upwards -tip_force 1", "-tip_law"),
    ("-tip_force hard", "-tip_force"),
    ("-tip_force -1 -tip_law resistance", "-tip_force"),
    ("-tip_force 1 -tip_field {field}", "-tip_field"),
    ("-tip_force 1 -tip_law resistance -tip_field {missing}", "-tip_field"),
    ("-tip_force 1 -tip_law resistance -tip_field {field_nan}", "-tip_field"),
    ("-tip_force 1 -tip_law resistance -tip_field {field_negative}", "-tip_field"),
    ("-tip_field {field}", "-tip_field"),
    ("-tip_type glued", "-tip_type"),
    ("-tip_type pinned -tip_force 1", "-tip_"),
    # growth at the tip, stiffness along the rod
    ("-growth_type apical -growth_zone 0", "-growth_zone"),
    ("-growth_zone 0.3", "-growth_zone"),
    ("-rod_stiffness_file {missing}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {table}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {stiffness_zero}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {stiffness_negative}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {stiffness_nan}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {stiffness_late}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {stiffness_unsorted}", "-rod_stiffness_file"),
    ("-rod_stiffness_file {stiffness_lengths}", "-rod_stiffness_file"),
    # events
    ("-stop_length 0.4", "-stop_length"),
    ("-stop_length long", "-stop_length"),
    ("-stop_angle 0", "-stop_angle"),
    ("-stop_angle -1", "-stop_angle"),
    ("-stop_angle 0.5 -shape_amplitude 1", "-stop_angle"),
    ("-stop_self_contact -0.1", "-stop_self_contact"),
    ("-stop_contact 0.1", "-stop_contact"),
    # sensitivities
    ("-sensitivity", "-sensitivity"),
    ("-sensitivity friction", "-sensitivity friction"),
    ("-sensitivity ts_rtol", "-sensitivity ts_rtol"),
    ("-sensitivity rod_cells", "-sensitivity rod_cells"),
    ("-sensitivity friction_mu,friction_mu", "twice"),
    ("-sensitivity friction_mu -rod_model auto", "-rod_model frame"),
    ("-sensitivity shape_turn", "is of rods in space"),
    ("-sensitivity rod_torsion", "is of rods in space"),
    ("-sensitivity friction_mu -friction_beta 0", "-friction_beta"),
    ("-sensitivity friction_mu -wall_file {wall_sound}", "contact"),
    ("-sensitivity friction_mu -ts_type bdf", "-ts_type"),
    ("-sensitivity growth_zone", "-sensitivity growth_zone"),
    ("-sensitivity friction_mu -shape_type mode", "-shape_type"),
    # contact
    ("-wall_file {missing}", "-wall_file"),
    ("-wall_file {directory}", "-wall_file"),
    ("-wall_file", "-wall_file"),
    ("-wall_file {empty}", "no wall"),
    ("-wall_file {table}", "-wall_file"),
    ("-wall_file {truncated}", "-wall_file"),
    ("-wall_file {wall_comments}", "no wall"),
    ("-wall_file {wall_unknown}", "line 2"),
    ("-wall_file {wall_few}", "line 1"),
    ("-wall_file {wall_many}", "line 1"),
    ("-wall_file {wall_bare}", "line 1"),
    ("-wall_file {wall_no_number}", "line 1"),
    ("-wall_file {wall_nan}", "line 1"),
    ("-wall_file {wall_normal}", "normal"),
    ("-wall_file {wall_unit}", "line 1"),
    ("-wall_file {wall_unit_odd}", "line 1"),
    ("-wall_file {wall_side}", "line 1"),
    ("-wall_file {wall_radius}", "radius"),
    ("-wall_file {wall_friction}", "friction"),
    ("-wall_file {wall_friction_none}", "line 1"),
    ("-wall_file {wall_friction_first}", "friction 0.3 0: is one number ... behind all others"),
    ("-wall_file {wall_friction_comma}", "friction 0,3: ... with a point: friction 0.3"),
    ("-wall_file {wall_circle_rises}", "stays in it ... give cylinder X1 X2 0 0 0 1 R"),
    ("-wall_file {wall_plane_turns}", "turns in it; let the axis be 0 0 1 ... give plane X1 X2 0 N1 N2 0"),
    *((f"-contact_diameter 0.1 -wall_file {{wall_{name}}}", words) for name, words in (
        ("moves_few", "moves: give moves VX VY VZ"), ("moves_row", "moves at: has 4 ... rows of four"),
        ("moves_ragged", "moves at: has 7 numbers"), ("moves_back", "moves: t must increase"),
        ("moves_word", "moves x: give a number"), ("moves_kilos", "moves 1kg: not a unit of length"),
        ("moves_twice", "moves is said twice"), ("moves_nowhere", "nowhere.csv: No such file"),
        ("moves_untimed", "untimed.csv: has no column t"), ("moves_still", "still.csv: has none of x1, x2, x3"),
        ("moves_once", "once.csv: needs two rows"), ("moves_spins", "column spin: ... t and x1, x2, x3"),
        ("turns_few", "turns: give turns RATE X Y Z AX AY AZ"), ("turns_file_bare", "turns: give turns RATE"),
        ("turns_axis", "turns: its axis has no direction"), ("turns_about", "about X Y Z AX AY AZ"),
        ("turns_row", "turns at: has 2 ... rows of two"), ("turns_ragged", "turns spin: has 3 numbers"),
        ("turns_back", "turns: t must increase"), ("turns_both", "both.csv: ... spin and turn"),
        ("turns_places", "column x1: ... t and spin, or t and turn"))),
    ("-wall_file {wall_narrow} -contact_diameter 0.2", "narrower"),
    ("-wall_file {wall_ring} -contact_diameter 0.2", "narrower"),
    ("-wall_file {wall_negative}", "line 1"),
    ("-wall_file {wall_sharp}", "sharply"),
    ("-wall_file {wall_back}", "line 1"),
    ("-wall_file {wall_twice}", "the same"),
    ("-wall_file {wall_twice_last}", "the same"),
    ("-wall_file {wall_crosses} -contact_diameter 0.1", "crosses itself"),
    ("-wall_file {wall_polygon}", "-contact_diameter"),
    ("-wall_file {wall_line} -contact_diameter 0.1", "no area"),
    ("-wall_file {wall_odd} -contact_diameter 0.1", "line 1"),
    ("-wall_file {wall_behind}", "starts in a wall"),
    ("-wall_file {wall_plane} -contact_diameter 1", "starts in a wall"),
    ("-contact_self -contact_diameter 0.2 -growth_initial_length 1 -shape_amplitude 6.5",
     "touches itself"),
    ("-contact_self", "-contact_diameter"),
    ("-contact_firm -wall_file {wall_sound}", "-contact_diameter"),
    ("-contact_firm -wall_file {wall_sound} -contact_diameter 0.1 -contact_stiffness 1e5", "-contact_stiffness"),
    ("-contact_firm -wall_file {wall_sound} -contact_diameter 0.1 -accuracy 1e-3", "-accuracy"),
    ("-contact_self maybe -contact_diameter 0.1", "-contact_self"),
    ("-contact_self -contact_diameter 0", "-contact_diameter"),
    ("-contact_self -contact_diameter -0.1", "-contact_diameter"),
    ("-contact_self -contact_diameter 0.1 -rod_order 2", "-rod_order"),
    ("-contact_friction 0.3", "-contact_friction"),
    ("-contact_friction 0.3 -contact_diameter 0.1", "-contact_friction"),
    ("-contact_friction -0.3 -wall_file {wall_sound}", "-contact_friction"),
    ("-contact_friction 0.3 -wall_file {wall_own}", "says its own friction"),
    ("-contact_friction 0.3 -wall_file {wall_own_space} -contact_diameter 0.1", "every wall of"),
    ("-wall_file {wall_comma}", "friction 0.5"),
    ("-wall_file {wall_comma_space}", "friction 0.5"),
    ("-wall_file {wall_blank}", "right behind its number, 50cm"),
    ("-contact_stiffness 1e5", "-contact_stiffness"),
    ("-contact_stiffness 0 -wall_file {wall_sound}", "-contact_stiffness"),
    ("-stop_contact", "-stop_contact"),
    ("-contact_diameter 0.1", "-contact_diameter: there is nothing to touch"),
    ("-rod_weight 0 0 -0.5", "put commas between numbers, 0,0"),
    # tubes and bodies
    ("-wall_file {wall_tube_kink} -contact_diameter 0.1", "kink of 90 degrees at point 2"),
    ("-wall_file {wall_tube_narrow} -contact_diameter 0.5", "narrower than the rod"),
    ("-wall_file {wall_tube_pinched} -contact_diameter 0.1", "narrower than the rod"),
    ("-wall_file {wall_tube_sharp} -contact_diameter 0.1", "bends with radius"),
    ("-wall_file {wall_tube_itself} -contact_diameter 0.1", "runs into itself"),
    ("-wall_file {wall_tube_off} -contact_diameter 0.1", "the clamp, at 0, is outside the tube"),
    ("-wall_file {wall_tube_beside} -contact_diameter 0.1", "or beside its mouth"),
    ("-wall_file {wall_tube_twice}", "the same"),
    ("-wall_file {wall_tube_flat}", "above 0"),
    ("-wall_file {wall_tube_bare}", "line 1"),
    ("-wall_file {wall_tube_odd}", "line 1"),
    ("-wall_file {wall_tube_missing}", "missing.csv"),
    ("-wall_file {wall_tube_columns}", "radius is missing"),
    ("-wall_file {wall_tube_word}", "radius of point 2"),
    ("-wall_file {wall_body_bare}", "line 1"),
    ("-wall_file {wall_body_missing}", "missing.h5"),
    ("-wall_file {wall_body_coarse} -contact_diameter 0.1", "too coarse for a rod of diameter 0.1"),
    ("-wall_file {wall_body_scaled} -contact_diameter 0.5", "is no distance"),
    ("-wall_file {wall_body_none}", "no surface in it"),
    ("-wall_file {wall_body_nan}", "ball_nan.h5"),
    ("-wall_file {wall_plane} -rod_model mixed", "mixed"),
    ("-wall_file {wall_plane} -rod_model linear", "-wall_file"),
    ("-contact_self -contact_diameter 0.1 -rod_model mixed", "mixed"),
    ("-wall_file {wall_plane} -task critical", "-task"),
    ("-wall_file {wall_plane} -task stability", "-task"),
    ("-contact_self -contact_diameter 0.1 -task critical", "-task"),
    # laboratory units
    ("-si_friction_dry 20", "-si_bending_stiffness"),
    ("-si_bending_stiffness 0 -si_friction_dry 20", "-si_bending_stiffness"),
    ("-si_bending_stiffness 1e-4", "-si_friction"),
    ("-si_bending_stiffness 1e-4 -si_friction_dry -20", "-si_friction_dry"),
    ("-si_bending_stiffness 1e-4 -si_friction_dry 20 -friction_mu 0.5", "-friction_mu"),
    ("-si_bending_stiffness 1e-4 -si_friction_viscous 20", "-si_speed"),
    ("-task units", "-si_"),
    # going on
    ("-restart {missing}", "-restart"),
    ("-restart {text}", "-restart"),
    ("-restart {truncated}", "-restart"),
    ("-restart {table}", "-restart"),
    ("-restart {directory}", "-restart"),
    ("-restart {result}", "-restart"),
    ("-restart {result} -ts_max_time 1 -rod_cells 30", "-rod_cells"),
    # accuracy
    ("-accuracy 0", "-accuracy"),
    ("-accuracy 1", "-accuracy"),
    ("-accuracy 1e-12", "-accuracy"),
    ("-accuracy high", "-accuracy"),
    ("-accuracy 1e-3 -task critical", "-accuracy"),
    # results
    ("-output {missing}/out.h5", "/missing), or name a file elsewhere"),
    ("-output {text}/out.h5", "Not a directory; name a file elsewhere"),
    ("-task critical -output {missing}/out.h5", "/missing), or name a file elsewhere"),
    ("-output {directory}", "-output"),
    ("-output /proc/out.h5", "or name a file elsewhere"),
    ("-output {text}", "-output"),
    ("-output {table_kept}", "-output"),
    ("-output", "-output"),
    ("-growth_type table -growth_table {table_kept} -output {table_kept}", "-output"),
    # a run that does not reach its end
    ("-ts_max_time 40 -ts_max_steps 5", "-ts_max_steps"),
    ("-eps_view", "-eps_view"),
]

AFTER_THE_START = ("-ts_max_steps", "-eps_view")  # these stop a run that has begun

# (ranks, command line, what the line must contain); mpiexec adds lines of its own
PARALLEL_CASES = [
    (3, "-rod_cells 4", "rank"),
    (2, "-friction_mu 1.5", "-friction_mu"),
    (2, "-friction_nu 1", "-friction_mu"),
    (2, "-options_file {missing}", "-options_file"),
    (2, "-growth_type table -growth_table {truncated}", "-growth_table"),
    (2, "-output {missing}/out.h5", "/missing; make it (mkdir -p "),
    (2, "-rod_cells 20 uniform", "uniform"),
]


def write_hdf5(path, **arrays):
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name] = values


def make_shapes(d, text):
    """Tubes and bodies, and the files that they name, which are beside theirs."""
    for name, line in (
            ("kink", "inside -1 0 0 0.2  3 0 0 0.2  3 5 0 0.2"), ("narrow", "inside -1 0 0 0.2  9 0 0 0.2"),
            ("pinched", "inside -1 0 0 0.6  3 0 0 0.6  7 0 0 0.1  11 0 0 0.1  15 0 0 0.6  19 0 0 0.6"),
            ("sharp", "inside -1 0 0 1.2  0 0 0 1.2  0.6 0.5 0 1.2  0.6 1.4 0 1.2"),
            ("itself", "inside" + "".join(f" {3 * sin(a / 3):.6f} {3 - 3 * cos(a / 3):.6f} 0 0.5" for a in range(-1, 20))),
            ("off", "inside -1 1 0 0.5  9 1 0 0.5"),
            ("beside", "inside 0.2 2 0 0.5  9 2 0 0.5"), ("twice", "inside -1 0 0 0.5 -1 0 0 0.5"),
            ("flat", "inside -1 0 0 0.5 1 0 0 0"), ("bare", ""), ("odd", "inside -1 0 0 0.5 1 0 0"),
            ("missing", "missing.csv inside"), ("columns", "columns.csv inside"), ("word", "word.csv inside")):
        text(f"wall_tube_{name}", f"tube {line}\n")
    text("columns.csv", "x,y,z\n-1,0,0\n9,0,0\n")
    text("word.csv", "x,y,z,r\n-1,0,0,0.5\n9,0,0,wide\n")
    places = [[[((k - 4) ** 2 + (j - 4) ** 2 + (i - 4) ** 2) ** 0.5 / 4 - 0.7 for i in range(9)] for j in range(9)]
              for k in range(9)]
    nan = [[[float("nan")] * 9] * 9] * 9
    scaled = [[[2.54 * v for v in row] for row in sheet] for sheet in places]
    none = [[[v + 1 for v in row] for row in sheet] for sheet in places]
    for name, values in (("coarse", places), ("scaled", scaled), ("none", none), ("nan", nan)):
        write_hdf5(d / f"ball_{name}.h5", distance=values, origin=[4.0, -1, -1], spacing=[0.25] * 3)
        text(f"wall_body_{name}", f"body ball_{name}.h5 outside\n")
    text("wall_shapes_sound", "tube inside -1 0 0 0.5  9 0 0 0.5\nbody ball_coarse.h5 outside friction 0.2\n")
    text("wall_body_bare", "body\n")
    text("wall_body_missing", "body missing.h5 inside\n")


def make_files(d, tendril):
    """Files to be refused, by name; the tables but one are spoilt in a single point each."""
    def text(name, content):
        (d / name).write_text(content)

    text("text", "s,t,g\n0,0,0.5\n")
    text("empty", "")
    text("unknown_opts", "# a scene\n-growth_type uniform\n-friction_nu 1\n")
    text("range_opts", "-friction_mu 7 # too large\n")
    text("dashless_opts", "-growth_type uniform\nfriction_mu 0.5\n")
    text("two_opts", "# a scene\n-growth_type uniform -friction_mu 0.5\n")
    text("blank_opts", "# a scene\n\n-ts_dt 0.1 ms\n")
    text("nul_opts", "-growth_type uniform\n-friction_mu 0.\0005\n")
    (d / "wide_opts").write_text("-friction_mu 0.5\n", encoding="utf-16")
    text("number_opts", "-5 3\n")
    text("dashes_opts", "--friction_mu 3\n")
    text("long_opts", f"-shape_file {'a' * 5000}\n")
    text("self_opts", f"-friction_mu 0.5\n-options_file {d}/self_opts\n")
    text("one_opts", "-options_file two_names_one\n")
    text("two_names_one", "-options_file one_opts\n")
    os.mkfifo(d / "pipe")
    (d / "directory").mkdir()
    (d / "scene").mkdir()  # what a scene names is beside it; else where one is
    text("scene/marked_opts", "\ufeff-wall_file wall\r\n-options_file more # some\n")
    text("scene/more", "! as PETSc has it\n-friction_field field\n\t-contact_diameter  0.1\n")
    text("scene/wall", "plane 5 0 -1 0\n")

    s, t = [0, 0.2, 0.4, 0.6, 0.8, 1], [0, 0.5, 1, 1.5, 2]
    g = [[0.5 + tk] * len(s) for tk in t]

    def g_with(value):
        return [[value if (i, k) == (2, 3) else x for i, x in enumerate(row)]
                for k, row in enumerate(g)]

    for name in ("table", "table_kept"):
        write_hdf5(d / name, s=s, t=t, g=g)
    write_hdf5(d / "table_turned", s=s, t=t, g=[list(column) for column in zip(*g)])
    write_hdf5(d / "table_flat", s=s, t=t, g=sum(g, []))
    write_hdf5(d / "table_nan", s=s, t=t, g=g_with(float("nan")))
    write_hdf5(d / "table_negative", s=s, t=t, g=g_with(-1.0))
    write_hdf5(d / "table_half", s=[x / 2 for x in s], t=t, g=g)
    write_hdf5(d / "table_unsorted", s=[0, 0.4, 0.2, 0.6, 0.8, 1], t=t, g=g)
    write_hdf5(d / "table_few", s=s, t=t[:2], g=g[:2])
    write_hdf5(d / "table_late", s=s, t=[x + 1 for x in t], g=g)
    write_hdf5(d / "table_words", s=[b"a"] * 6, t=t, g=g)
    write_hdf5(d / "shape_lengths", s=s, theta=[0, 0.1, 0.2])
    write_hdf5(d / "shape_turned", s=s, theta=[0.1] * 6)
    write_hdf5(d / "curvature_nan", s=s, curvature=[0, 0, float("nan"), 0, 0, 0])
    x1, x2 = [0, 1, 2, 3, 4], [-1, 0, 1]

    def spoilt(value, row=1, column=2):
        return [[value if (i, j) == (row, column) else 1.0 for j in range(5)] for i in range(3)]

    write_hdf5(d / "field", x1=x1, x2=x2, factor=spoilt(1.5))
    write_hdf5(d / "field_across", x1=x1, x2=x2, factor=[[k] * 5 for k in (1.0, 2.0, 3.0)])
    write_hdf5(d / "field_negative", x1=x1, x2=x2, factor=spoilt(-1.0))
    write_hdf5(d / "field_dips", x1=x1, x2=x2, factor=[[0.0, 0.0, 9.0, 9.0, 0.0]] * 3)
    write_hdf5(d / "field_nan", x1=x1, x2=x2, factor=spoilt(float("nan")))
    write_hdf5(d / "field_unsorted", x1=[0, 2, 1, 3, 4], x2=x2, factor=spoilt(1.0))
    write_hdf5(d / "field_turned", x1=x1, x2=x2, factor=[[1.0] * 3] * 5)
    write_hdf5(d / "field_no_factor", x1=x1, x2=x2)
    far = [0, 1, 2, 3]
    write_hdf5(d / "stiffness", distance=far, factor=[1.0, 2.0, 2.5, 3.0])
    write_hdf5(d / "stiffness_zero", distance=far, factor=[1.0, 0.0, 1.0, 1.0])
    write_hdf5(d / "stiffness_negative", distance=far, factor=[1.0, 1.0, -1.0, 1.0])
    write_hdf5(d / "stiffness_nan", distance=far, factor=[1.0, float("nan"), 1.0, 1.0])
    write_hdf5(d / "stiffness_late", distance=[x + 1 for x in far], factor=[1.0] * 4)
    write_hdf5(d / "stiffness_unsorted", distance=[0, 2, 1, 3], factor=[1.0] * 4)
    write_hdf5(d / "stiffness_lengths", distance=far, factor=[1.0] * 5)
    text("wall_sound", "\ufeff# a hall\nplane 5 0 -1 0 # ahead\n\ncircle 3 2 1 outside friction 0.2\n"
         "polygon outside 3,-3 4,-3 4,-2 friction 0\npath 1 -1 0 8 0 10 2\n")
    text("wall_own", "circle 3 2 1 outside friction 0.2\nplane 9 0 -1 0 friction 0\n")
    text("wall_own_space", "cylinder 0 0 0 1 0 0 2 inside friction 0.5\n")
    text("wall_comma", "plane 9 0 -1 0 friction 0,5\n")
    text("wall_comma_space", "cylinder 0 0 0 1 0 0 2 inside friction 0,5\n")
    text("wall_blank", "circle 3 2 50 cm outside\n")
    text("wall_metres", "plane 50cm 0 -1 0\ncircle 0.5m 300mm 0.1m outside friction 0.2\n")
    for name, line in (
            ("comments", "# nothing\n\n   \n"), ("unknown", "plane 5 0 -1 0\nsquare 1 2 3"),
            ("few", "plane 5 0 -1"), ("many", "plane 5 0 -1 0 7"), ("bare", "circle"),
            ("no_number", "plane 5 0 left 0"), ("nan", "plane nan 0 -1 0"),
            ("normal", "plane 5 0 0 0"), ("unit", "plane 5kg 0 -1 0"),
            ("unit_odd", "plane 5 0 -1m 0"), ("side", "circle 5 0 1 around"),
            ("radius", "circle 5 0 -1 outside"), ("friction", "plane 5 0 -1 0 friction -1"),
            ("friction_none", "plane 5 0 -1 0 friction"),
            ("friction_first", "tube inside friction 0.3 0 0 0 1 2 0 0 1"),
            ("friction_comma", "tube inside 0 0 0 1 2 0 0 1 friction 0,3"), ("narrow", "path 0.05 -1 0 9 0"),
            ("ring", "circle 0 0 0.05 inside"), ("negative", "path -1 -1 0 9 0"),
            ("sharp", "path 1 -2 0 2 0 2 0.5 -2 0.5"), ("back", "path 0.1 -1 0 3 0 1 0"),
            ("twice", "path 1 -1 0 -1 0 9 0"), ("twice_last", "path 1 -1 0 9 0 9 0"),
            ("crosses", "polygon outside 2 -1 4 1 4 -1 2 1.5"),
            ("polygon", "polygon outside 2 -1 4 -1 3 1"),
            ("line", "polygon outside 2 -1 3 -1 4 -1"), ("odd", "polygon outside 2 -1 4 -1 3"),
            ("plane", "plane 0.7 0 -1 0"), ("behind", "plane 0.1 0 -1 0"),
            ("circle_rises", "circle 5 0 1 outside moves at 0 0 0 0 1 0 0 1"), ("plane_turns", "plane 5 0 -1 0 turns 1 5 0 0 0 1 1")):
        text(f"wall_{name}", line + "\n")
    for name, line in (
            ("moves_few", "moves 1 0"), ("moves_row", "moves at 0 0 0 0"), ("moves_ragged", "moves at 0 0 0 0 1 0 0"),
            ("moves_back", "moves at 1 0 0 0 1 1 0 0"), ("moves_word", "moves at 0 0 0 0 1 x 0 0"),
            ("moves_kilos", "moves at 0 0 0 0 1 1kg 0 0"), ("moves_twice", "moves 1 0 0 moves 0 1 0"),
            *((f"moves_{name}", f"moves {name}.csv") for name in ("nowhere", "untimed", "still", "once", "spins")),
            ("turns_few", "turns 1 0 0 0"), ("turns_file_bare", "turns both.csv"), ("turns_axis", "turns 1 0 0 0 0 0 0"),
            ("turns_about", "turns at 0 0 1 1 0 0 0 0 0 1"), ("turns_row", "turns at 0 0 about 0 0 0 0 0 1"),
            ("turns_ragged", "turns spin 0 0 1 about 0 0 0 0 0 1"), ("turns_back", "turns at 1 0 0 1 about 0 0 0 0 0 1"),
            ("turns_both", "turns both.csv 0 0 0 0 0 1"), ("turns_places", "turns untimed.csv 0 0 0 0 0 1"),
            ("moves_sound", "moves at 0 1 0 0 1 2 0 0 turns spin 0 0 1 90deg about 0 0 0 0 0 1 friction 0.2"),
            ("moves_sound_files", "turns turn.csv 9cm 0 0 0 0 1 moves place.csv")):
        text(f"wall_{name}", f"sphere 9 0 0 1 outside {line}\n")
    for name, lines in (("untimed", "x1\n0\n1\n"), ("still", "t\n0\n1\n"), ("once", "t,x1\n0,0\n"), ("spins", "t,spin\n0,0\n1,1\n"),
                        ("both", "t,spin,turn\n0,0,0\n1,1,1\n"), ("place", "t,x1\n0s,0\n1s,2mm\n"), ("turn", "t,turn\n0,0\n1,90deg\n")):
        text(f"{name}.csv", lines)
    make_shapes(d, text)
    whole = (d / "table").read_bytes()
    (d / "truncated").write_bytes(whole[: len(whole) // 2])

    # sound input is accepted without a word, else the refusals would prove nothing
    text("sound_opts", "# a scene\n-growth_type gaussian # a law\n-growth_width 0.3\n")
    for line in SOUND:
        done = run([tendril, *SHORT, "-output", "result", *line.split()], d)
        if done.returncode != 0 or done.stderr:
            sys.exit(f"bad_input: sound input is refused: {line}\n{done.stderr}")
    return {p.name: str(p) for p in d.iterdir()} | {"missing": str(d / "missing")}


def run(command, directory):
    return subprocess.run(command, cwd=directory, stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, errors="replace", timeout=HANG)


def complaints(stderr, expected, alone):
    """What is wrong with a refusal; alone: nothing but the one line may stand on stderr."""
    lines = [line for line in stderr.splitlines() if line.strip()]
    ours = [line for line in lines if line.startswith("tendril: ")]
    if len(ours) != 1:
        yield f"{len(ours)} lines start with 'tendril: '"
    elif any(part not in ours[0] for part in expected.split(" ... ")):
        yield f"the line does not contain {expected}"
    elif len(ours[0]) > 300:
        yield "the line is too long"
    if alone and len(lines) > len(ours):
        yield f"{len(lines) - len(ours)} other lines on stderr"
    for mark in ("PETSC ERROR", "HDF5-DIAG", "Segmentation", "Signal:"):
        if mark in stderr:
            yield f"{mark} on stderr"


def check_refusal(command, expected, directory, alone=True):
    old = directory / "out.h5"  # a result of an earlier run, which a refused one must not touch
    before = (directory / "result").read_bytes()
    old.write_bytes(before)
    try:
        done = run(command, directory)
    except subprocess.TimeoutExpired:
        return [f"still going after {HANG} s"], ""
    wrong = list(complaints(done.stderr, expected, alone))
    if expected not in AFTER_THE_START and old.read_bytes() != before:
        wrong.append("an older result was overwritten")
    if done.returncode == 0:
        wrong.insert(0, "exit code 0")
    elif done.returncode < 0 or done.returncode >= 128:
        wrong.insert(0, f"ended by a signal, exit code {done.returncode}")
    return wrong, done.stderr


def start_and_stop(tendril, directory, number):
    """A run stopped by a signal when its result file has grown; (file, exit code, stderr, fault)."""
    result = directory / f"stopped_{number}.h5"

    def stored():
        if not result.exists():
            return 0
        with h5py.File(result) as file:
            return len(file["shapes/t"])

    with Held([tendril, "-output", result, "-output_interval", "0.01", "-rod_cells", "100"],
              cwd=directory, stdin=subprocess.DEVNULL) as run:
        run.let(20 * PAGE)
        if not run.until(lambda: stored() > 1):
            return result, None, "", "ended before it could be stopped"
        run.send_signal(number)
        return result, *run.end(), None


def check_stop(tendril, directory, number):
    result, code, stderr, wrong = start_and_stop(tendril, directory, number)
    if wrong:
        return [wrong], stderr
    wrong = []
    if number != signal.SIGKILL:
        wrong += complaints(stderr, "t = ", True)
        if code <= 0 or code == 127:
            wrong.append(f"no clean end: exit code {code}")
    try:
        with h5py.File(result, "r") as file:
            shapes, steps = file["shapes/t"][()], file["series/t"][()]
            for name in ("x", "theta", "curvature", "force"):
                if len(file[f"shapes/{name}"]) != len(shapes):
                    wrong.append(f"shapes/{name} and shapes/t differ in length")
                file[f"shapes/{name}"][-1]
            for name, series in file["series"].items():
                if len(series) != len(steps):
                    wrong.append(f"series/{name} and series/t differ in length")
            if int(file.attrs["finished"]) != 0:
                wrong.append("the file says finished")
        if not len(shapes) or not len(steps):
            wrong.append(f"{len(shapes)} shapes and {len(steps)} steps in the file")
        elif number != signal.SIGKILL and shapes[-1] != steps[-1]:
            wrong.append(f"last shape at t = {shapes[-1]}, last step at t = {steps[-1]}")
    except (OSError, KeyError) as error:
        wrong.append(f"the file cannot be read: {error}")
    return wrong, stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tendril")
    parser.add_argument("--mpiexec", default=shutil.which("mpiexec"))
    parser.add_argument("--only", default="", help="run the cases whose command line has this")
    parser.add_argument("--verbose", action="store_true", help="show what every case printed")
    choice = parser.parse_args()
    os.environ.update(OMP_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1",
                      OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                      OMPI_MCA_ess_singleton_isolated="1",  # no helper process: a quicker start
                      OMPI_MCA_odls_base_sigkill_timeout="0")  # and no second's wait for the other ranks of a refusal
    tendril = str(Path(choice.tendril).resolve())
    count = failed = 0

    def report(name, outcome):
        nonlocal count, failed
        wrong, stderr = outcome
        count += 1
        failed += bool(wrong)
        if wrong or choice.verbose:
            print(f"{'FAILED' if wrong else 'ok'}: {name}: {'; '.join(wrong)}")
            for line in stderr.splitlines()[:6]:
                print(f"    | {line}", flush=True)

    twice = [case for case in CASES if CASES.count(case) > 1]
    if twice:
        report("cases", ([f"stands there twice: {twice[0]}"], ""))
    with tempfile.TemporaryDirectory(prefix="tendril-") as name:
        directory = Path(name)
        files = make_files(directory, tendril)
        for line, expected in CASES:
            if choice.only in line:
                command = [tendril, *SHORT, *line.format(**files).split()]
                report(line, check_refusal(command, expected, directory))
        for ranks, line, expected in PARALLEL_CASES if choice.mpiexec else []:
            if choice.only in line:
                command = [choice.mpiexec, "-n", str(ranks), "--oversubscribe", tendril, *SHORT,
                           *line.format(**files).split()]
                report(f"{ranks} ranks, {line}",
                       check_refusal(command, expected, directory, alone=False))
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            if choice.only in number.name:
                report(number.name, check_stop(tendril, directory, number))
    print(f"bad_input: {count - failed} of {count} cases as they should be")
    return 1 if failed or not count else 0


if __name__ == "__main__":
    sys.exit(main())
