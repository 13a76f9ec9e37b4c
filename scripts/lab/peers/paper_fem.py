#!/usr/bin/python3
"""The method of Horvath, Sipos and Varkonyi, written anew on dolfin: mixed elements of degree 3 for
x1, x2 and lambda, interior penalty for the bending, backward differences at a fixed step, Newton.

    /usr/bin/python3 scripts/lab/peers/paper_fem.py -growth_initial_length 2 -shape_amplitude 0.1 \
        -ts_max_time 5 -times 1,5 -dt 0.01 -nel 64

Takes tendril's options for the scene (uniform and gaussian growth, sag, beta > 0) and
  -nel N      elements, even in s          -dt DT      the step; the times are multiples of it
  -graded     elements dense where a growth zone is narrow, as tendril has them
  -literal    the paper as it stands: Newton from the last step, test on the residual, no condition
              on lambda(1); else lambda(1) = 0, start by extrapolation, test on increments
Prints a JSON line per time, and one of the cost (loop alone, without the compilation of forms).
Exit 3: the scene is not supported; 1: it failed."""

import json
import os
import sys
import time
from math import erf, pi, sqrt

os.environ.setdefault("OMP_NUM_THREADS", "1")
import dolfin as df  # noqa: E402  (after the number of threads)
import numpy as np  # noqa: E402

DEGREE = 3
PENALTY = 10.0
MOST_ITERATIONS = 50


def arguments(words):
    options = {"growth_type": "uniform", "growth_initial_length": "0.5", "growth_width": "0.5",
               "friction_mu": "1", "friction_beta": "1e-3", "shape_type": "sag",
               "shape_amplitude": "0.01", "ts_max_time": "40", "output_interval": "", "times": "",
               "nel": "64", "dt": "0.01", "literal": "", "graded": ""}
    k = 0
    while k < len(words):
        name = words[k].lstrip("-")
        if name not in options:
            refuse(f"-{name}: not supported")
        if name in ("literal", "graded"):
            options[name] = "yes"
            k += 1
        else:
            options[name] = words[k + 1]
            k += 2
    return options


def refuse(message):
    print(f"paper_fem: {message}", file=sys.stderr)
    sys.exit(3)


class Rod:
    def __init__(self, options):
        number = {k: float(options[k]) for k in ("growth_initial_length", "growth_width",
                                                 "friction_mu", "friction_beta",
                                                 "shape_amplitude", "dt")}
        if options["growth_type"] not in ("uniform", "gaussian") or options["shape_type"] != "sag":
            refuse("uniform or gaussian growth of a sag only")
        if number["friction_beta"] <= 0:
            refuse("-friction_beta: needs a value above 0")
        self.literal = bool(options["literal"])
        self.dt, self.L0 = number["dt"], number["growth_initial_length"]
        self.cells = int(options["nel"])
        mesh = df.UnitIntervalMesh(self.cells)
        if options["graded"] and options["growth_type"] == "gaussian":
            self.grade(mesh, number["growth_width"], float(options["ts_max_time"]))
        P = df.FiniteElement("CG", mesh.ufl_cell(), DEGREE)
        self.space = df.FunctionSpace(mesh, df.MixedElement([P, P, P]))
        self.now, self.old = df.Function(self.space), df.Function(self.space)
        self.t = df.Constant(0.0)
        s = df.SpatialCoordinate(mesh)[0]
        if options["growth_type"] == "gaussian":
            a = number["growth_width"]
            b = 2 / (a * sqrt(pi) * erf(1 / a))
            self.g = self.L0 + b * df.exp(-(s / a) ** 2) * self.t
        else:
            self.g = self.L0 + self.t + 0 * s
        self.forms(mesh, number)
        self.start(number)

    def grade(self, mesh, width, end):
        """Nodes even in the arc length at the end, plus half as many even in s."""
        s = np.concatenate(([0], np.logspace(-6, 0, 20000)))
        zone = np.array([erf(x / width) for x in s]) / erf(1 / width)
        along = (self.L0 * s + end * zone) / (self.L0 + end) + s / 2
        mesh.coordinates()[:, 0] = np.interp(mesh.coordinates()[:, 0], along / along[-1], s)

    def forms(self, mesh, number):
        """bending'' + g phi(|x_t|) x_t + 2 (lambda x')' = 0,  |x'|^2 = g^2, tested by e and z"""
        g, dt = self.g, df.Constant(self.dt)
        mu, beta = number["friction_mu"], number["friction_beta"]
        h, normal = df.CellVolume(mesh), df.FacetNormal(mesh)[0]
        x1, x2, lam = df.split(self.now)
        y1, y2, _ = df.split(self.old)
        e1, e2, z = df.TestFunctions(self.space)
        clamp = df.CompiledSubDomain("on_boundary && near(x[0], 0)")
        tip = df.CompiledSubDomain("on_boundary && near(x[0], 1)")
        marks = df.MeshFunction("size_t", mesh, 0, 0)
        clamp.mark(marks, 1)
        ds = df.Measure("ds", domain=mesh, subdomain_data=marks)(1)
        v1, v2 = (x1 - y1) / dt, (x2 - y2) / dt
        phi = (1 - mu) + mu / df.sqrt(v1 ** 2 + v2 ** 2 + beta)
        F = g * phi * (v1 * e1 + v2 * e2) * df.dx
        F -= 2 * lam * (x1.dx(0) * e1.dx(0) + x2.dx(0) * e2.dx(0)) * df.dx
        F -= (x1.dx(0) ** 2 + x2.dx(0) ** 2 - g ** 2) * z * df.dx
        for x, e, slope in ((x1, e1, g), (x2, e2, df.Constant(0))):
            bend, bend_e = x.dx(0).dx(0) / g ** 3, e.dx(0).dx(0) / g ** 3
            jump, jump_e = 2 * df.avg(x.dx(0) * normal), 2 * df.avg(e.dx(0) * normal)
            miss, stiff = x.dx(0) - slope, PENALTY / (h * g ** 3)
            F += bend * e.dx(0).dx(0) * df.dx
            F += (df.avg(stiff) * jump * jump_e - df.avg(bend) * jump_e - df.avg(bend_e) * jump) \
                * df.dS
            F += (stiff * miss * e.dx(0) - bend * normal * e.dx(0) - bend_e * normal * miss) * ds
        self.F = df.Form(F)
        self.J = df.Form(df.derivative(F, self.now, df.TrialFunction(self.space)))
        self.bcs = [df.DirichletBC(self.space.sub(i), df.Constant(0), clamp) for i in (0, 1)]
        if not self.literal:
            self.bcs.append(df.DirichletBC(self.space.sub(2), df.Constant(0), tip))
        kappa = (x1.dx(0) * x2.dx(0).dx(0) - x2.dx(0) * x1.dx(0).dx(0)) / g ** 3
        self.norm, self.energy = df.Form(x2 ** 2 * df.dx), df.Form(kappa ** 2 * g / 2 * df.dx)
        self.A, self.b, self.update = df.PETScMatrix(), df.PETScVector(), df.Function(self.space)
        self.solver = df.PETScLUSolver(self.A, "mumps")

    def start(self, number):
        """The sag theta = eps (1 - (1-s)^3), and lambda of the straight rod."""
        self.dofs = [np.array(self.space.sub(i).dofmap().dofs()) for i in range(3)]
        s = self.space.tabulate_dof_coordinates()[:, 0]
        self.dofs = [d[np.argsort(s[d])] for d in self.dofs]
        s = s[self.dofs[0]]
        node, weight = np.polynomial.legendre.leggauss(8)
        points = s[:-1, None] + np.diff(s)[:, None] * (node + 1) / 2
        theta = number["shape_amplitude"] * (1 - (1 - points) ** 3)
        u = np.zeros(self.space.dim())
        for i, f in ((0, np.cos(theta)), (1, np.sin(theta))):
            u[self.dofs[i][1:]] = self.L0 * np.cumsum(f @ weight * np.diff(s) / 2)
        mu, beta = number["friction_mu"], number["friction_beta"]
        u[self.dofs[2]] = mu * (np.sqrt(1 + beta) - np.sqrt(s ** 2 + beta)) / 2 \
            + (1 - mu) * (1 - s ** 2) / 4
        self.put(self.now, u)
        self.put(self.old, u)
        self.before = None

    @staticmethod
    def put(function, values):
        function.vector().set_local(values)
        function.vector().apply("insert")

    def guess(self, ratio):
        last = self.now.vector().get_local()
        if self.literal:
            return last
        if self.before is None:
            first = last.copy()
            first[np.concatenate(self.dofs[:2])] *= ratio
            return first
        return 2 * last - self.before

    def residual(self):
        df.assemble(self.F, tensor=self.b)
        for bc in self.bcs:
            bc.apply(self.b, self.now.vector())
        return self.b.norm("l2")

    def step(self, k):
        """Newton iterations taken; raises RuntimeError."""
        t = k * self.dt
        first = self.guess((self.L0 + t) / (self.L0 + t - self.dt))
        last = self.now.vector().get_local()
        self.t.assign(t)
        self.put(self.now, first)
        r = r0 = self.residual()
        change = np.inf
        for it in range(1, MOST_ITERATIONS + 1):
            df.assemble(self.J, tensor=self.A)
            for bc in self.bcs:
                bc.apply(self.A)
            try:
                self.solver.solve(self.update.vector(), self.b)
            except RuntimeError:
                raise RuntimeError(f"LU failed, a zero pivot, at t = {t:g}") from None
            self.now.vector().axpy(-1, self.update.vector())
            du, u = self.update.vector().get_local(), self.now.vector().get_local()
            change = max(np.abs(du[d]).max() / max(np.abs(u[d]).max(), 1e-300)
                         for d in self.dofs[:2])
            r = self.residual()
            if not np.isfinite(r):
                break
            if (r <= max(1e-10, 1e-4 * r0)) if self.literal else change <= 1e-4:
                self.before = last
                self.put(self.old, self.now.vector().get_local())
                return it
        raise RuntimeError(f"Newton failed at t = {t:g}")

    def observe(self, t):
        u = self.now.vector().get_local()
        return {"t": t, "tip": [u[self.dofs[0][-1]], u[self.dofs[1][-1]]],
                "norm_x2": df.assemble(self.norm) ** 0.5, "energy": df.assemble(self.energy)}


def main():
    df.set_log_level(df.LogLevel.ERROR)
    df.parameters["form_compiler"]["quadrature_degree"] = 8
    df.parameters["form_compiler"]["optimize"] = True
    options = arguments(sys.argv[1:])
    rod = Rod(options)
    times = [float(t) for t in options["times"].split(",") if t]
    steps = round(float(options["ts_max_time"]) / rod.dt)
    due = {round(t / rod.dt): t for t in times}
    rod.residual()  # whatever is compiled or set up once
    newton, k, failed = 0, 0, ""
    begin = time.perf_counter()
    for k in range(1, steps + 1):
        try:
            newton += rod.step(k)
        except RuntimeError as error:
            failed = str(error).strip().splitlines()[-1]
            break
        if k in due:
            print(json.dumps(rod.observe(due[k])), flush=True)
    state = {"seconds": time.perf_counter() - begin, "steps": k, "newton": newton,
             "work": newton * rod.space.dim()}
    print(json.dumps(dict(state, failed=failed) if failed else state))
    if failed:
        print(f"paper_fem: {failed}", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
