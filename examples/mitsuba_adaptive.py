"""Mitsuba 3 under pmcip: where its samples go is decided by pmcip, what they see by Mitsuba's own integrator.

    pip install mitsuba ./python
    python examples/mitsuba_adaptive.py [SCENE.xml] [--spp 16] [--reference-spp 1024] [-o comparison.png]

Renders a scene by Mitsuba alone, by Mitsuba under pmcip, and by the same with pmcip's filter, then by Mitsuba alone for as long as
these took; prints seconds and errors against a reference by Mitsuba alone, and writes all pictures side by side, the reference last.
Without a scene it is Mitsuba's Cornell box.
"""

import argparse
import time

import mitsuba as mi
import numpy as np

if __name__ == "__main__":
    mi.set_variant("llvm_ad_rgb")

import drjit as dr
import pmcip


def mix(x):
    """Mixes 32 bits."""
    x = x ^ 0x5BD1E995
    x = (x ^ (x >> 16)) * 0x7FEB352D
    x = (x ^ (x >> 15)) * 0x846CA68B
    return x ^ (x >> 16)


def owen(x, seed):
    """Owen scrambling of bit-reversed numbers."""
    x = x ^ (x * 0x3D20ADEA)
    x = (x + seed) * ((seed >> 16) | 1)
    x = x ^ (x * 0x05526C56)
    return x ^ (x * 0x53A22864)


def pascal(x):
    """The second Sobol coordinate, bits reversed."""
    x = x ^ (x >> 16)
    for shift, mask in (8, 0xFF00FF00), (4, 0xF0F0F0F0), (2, 0xCCCCCCCC), (1, 0xAAAAAAAA):
        x = x ^ ((x & mask) >> shift)
    return x


def unit(x):
    """Bit-reversed numbers as fractions."""
    return mi.Float(dr.brev(x) >> 8) * 2.0**-24


class Points(mi.Sampler):
    """pmcip's points as Mitsuba's random numbers: stratified in every pixel, however many samples it gets.

    The same bits as `Plan.points`, made where they are used: a set for every pair of numbers, in the middle of loops, too.
    """

    def __init__(self):
        super().__init__(mi.Properties())
        self.index, self.key, self.set = mi.UInt32(0), mi.UInt32(0), mi.UInt32(0)

    def start(self, plan):
        """The samples of a plan, from set 1 on: set 0 is the film position."""
        self.index, self.key, self.set = mi.UInt32(plan.index), mi.UInt32(plan.key), mi.UInt32(1)
        return self

    def next_2d(self, active=True):
        key = mix(self.key ^ mix(self.set))
        index = dr.brev(owen(dr.brev(self.index), key))
        self.set = self.set + 1
        u, v = owen(index, mix(key ^ 0x9E3779B9)), owen(pascal(index), mix(key ^ 0x85EBCA6B))
        return mi.Point2f(unit(u), unit(v))

    def next_1d(self, active=True):
        return self.next_2d(active).x


def rays(scene, sampler, x, y):
    """Rays through film positions in pixels."""
    sensor = scene.sensors()[0]
    width, height = sensor.film().size()
    position = mi.Point2f(mi.Float(x) / float(width), mi.Float(y) / float(height))
    return sensor.sample_ray_differential(0.0, 0.5, position, sampler.next_2d())


def radiance(scene, sampler):
    """What Mitsuba sees along the rays of a plan: the function that pmcip samples."""

    def evaluate(plan):
        ray, weight = rays(scene, sampler.start(plan), plan.x, plan.y)
        light, _, _ = scene.integrator().sample(scene, sampler, ray, None, True)
        return dr.ravel(mi.Color3f(weight * light)).numpy().reshape(-1, 3)

    return evaluate


@dr.syntax
def first_rough(scene, ray):
    """Albedo, normal and depth where rays end that go on through glass and along mirrors; zeros where nothing is."""
    albedo, normal, depth = mi.Color3f(0.0), mi.Normal3f(0.0), mi.Float(0.0)
    ray, length, bounce, active = mi.Ray3f(ray), mi.Float(0.0), mi.UInt32(0), mi.Bool(True)
    while active & (bounce < 8):
        si = scene.ray_intersect(ray, active)
        active &= si.is_valid()
        length = dr.select(active, length + si.t, length)
        bsdf, lamp = si.bsdf(), si.shape.is_emitter()
        ends = active & (mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth) | lamp)
        seen = dr.select(lamp, mi.Color3f(1.0), bsdf.eval_diffuse_reflectance(si, ends))
        albedo, normal = dr.select(ends, seen, albedo), dr.select(ends, si.sh_frame.n, normal)
        depth = dr.select(ends, length, depth)
        active &= ~ends
        # On through glass where it lets light through, else along the reflection.
        onward, _ = bsdf.sample(mi.BSDFContext(), si, 0.999, mi.Point2f(0.5), active)
        ray = si.spawn_ray(si.to_world(onward.wo))
        bounce += 1
    return albedo, normal, depth


def features(scene, seed=0, samples=8):
    """Albedo, normal and depth of every pixel, means of some rays: what the filter goes by."""
    width, height = (int(side) for side in scene.sensors()[0].film().size())
    film = pmcip.Film(width, height, uniform=True, seed=seed)
    film.begin(samples * width * height)
    plan = film.plan()
    ray, _ = rays(scene, Points().start(plan), plan.x, plan.y)
    albedo, normal, depth = first_rough(scene, ray)
    pixel = mi.UInt32(mi.Float(plan.y)) * width + mi.UInt32(mi.Float(plan.x))

    def mean(*channels):
        plane = dr.zeros(mi.Float, width * height * len(channels))
        for i, channel in enumerate(channels):
            dr.scatter_add(plane, channel / samples, pixel * len(channels) + i)
        return plane.numpy()

    shape = (height, width, 3)
    return mean(*albedo).reshape(shape), mean(*normal).reshape(shape), mean(depth).reshape(shape[:2])


def adaptive(scene, spp, seed=0, iterations=None):
    """A film of `spp` samples a pixel, all of them Mitsuba's."""
    width, height = (int(side) for side in scene.sensors()[0].film().size())
    film = pmcip.Film(width, height, spp=spp, seed=seed)
    film.render(radiance(scene, Points()), spp, iterations=iterations or max(2, spp // 2))
    return film


def alone(scene, spp, seed=0):
    """Mitsuba's own picture."""
    return np.array(mi.render(scene, spp=spp, seed=seed))[..., :3]


def timed(render):
    """A picture and its seconds, after one that compiles Mitsuba's kernels."""
    render()
    start = time.perf_counter()
    return render(), time.perf_counter() - start


def error(picture, reference):
    """Mean of squared errors over squared radiance, the worst 0.1 % of pixels left out."""
    each = np.sort(np.mean((picture - reference) ** 2 / (reference**2 + 1e-2), axis=-1).ravel())
    return each[: -max(1, each.size // 1000)].mean()


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scene", nargs="?", help="a scene file of Mitsuba's, with a box filter")
    arguments.add_argument("--spp", type=int, default=16, help="samples a pixel")
    arguments.add_argument("--reference-spp", type=int, default=1024, help="samples a pixel of the reference")
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("-o", "--output", default="comparison.png", help="the pictures side by side")
    asked = arguments.parse_args()
    if asked.scene:
        scene = mi.load_file(asked.scene)
    else:
        box = mi.cornell_box()
        box["sensor"]["film"]["rfilter"] = {"type": "box"}
        scene = mi.load_dict(box)
    spp, seed = asked.spp, asked.seed
    runs = {
        "Mitsuba alone": timed(lambda: alone(scene, spp, seed)),
        "under pmcip": timed(lambda: adaptive(scene, spp, seed).resolve()),
        "and filtered": timed(lambda: adaptive(scene, spp, seed).guided(*features(scene, seed))),
    }
    seconds = [run[1] for run in runs.values()]
    for name, limit in ("as long as under pmcip", seconds[1]), ("as long as filtered", seconds[2]):
        more = max(1, round(spp * limit / seconds[0]))
        runs[f"alone, {name}"] = timed(lambda: alone(scene, more, seed))
    parts = [alone(scene, 64, 1000 + i) for i in range(max(1, asked.reference_spp // 64))]
    reference = np.mean(parts, axis=0)
    for name, (picture, taken) in runs.items():
        energy = picture.sum() / reference.sum() - 1
        print(f"{name:29} {taken:6.2f} s, relMSE {error(picture, reference):.3e}, energy {energy:+.2%}")
    strip = np.concatenate([*(picture for picture, _ in runs.values()), reference], axis=1)
    mi.util.write_bitmap(asked.output, mi.TensorXf(np.ascontiguousarray(strip, dtype=np.float32)), write_async=False)


if __name__ == "__main__":
    main()
