"""Mitsuba 3 under pmcip: where its samples go is decided by pmcip, what they see by Mitsuba's own integrator.

    pip install mitsuba ./python
    python examples/mitsuba_adaptive.py [SCENE.xml] [--spp 16] [--reference-spp 1024] [-o comparison.png]

Renders a scene by Mitsuba alone, by Mitsuba under pmcip, and by the same with pmcip's filter; prints the errors against a
reference by Mitsuba alone and writes the four pictures side by side. Without a scene it is Mitsuba's Cornell box.
"""

import argparse

import mitsuba as mi
import numpy as np

if __name__ == "__main__":
    mi.set_variant("llvm_ad_rgb")

import drjit as dr
import pmcip


def points_sampler():
    """A sampler whose random numbers are pmcip's points: stratified in every pixel, however many samples it gets."""

    class Points(mi.Sampler):
        def start(self, plan):
            self.plan, self.set = plan, 1
            return self

        def next_2d(self, active=True):
            u, v = self.plan.points(self.set)
            self.set += 1
            return mi.Point2f(mi.Float(u), mi.Float(v))

        def next_1d(self, active=True):
            return self.next_2d(active).x

    return Points(mi.Properties())


def rays(scene, sampler, x, y):
    """Rays through film positions in pixels."""
    sensor = scene.sensors()[0]
    width, height = sensor.film().size()
    position = mi.Point2f(mi.Float(x) / float(width), mi.Float(y) / float(height))
    return sensor.sample_ray_differential(0.0, 0.5, position, sampler.next_2d())


def radiance(scene, sampler):
    """What Mitsuba sees along the rays of a plan: the function that pmcip samples."""

    def evaluate(plan):
        sampler.start(plan)
        # The sampler counts its dimensions in Python: loops must run, not be recorded.
        with dr.scoped_set_flag(dr.JitFlag.SymbolicLoops, False):
            ray, weight = rays(scene, sampler, plan.x, plan.y)
            light, _, _ = scene.integrator().sample(scene, sampler, ray, None, True)
            rgb = mi.Color3f(weight * light)
            return np.ascontiguousarray(np.array(rgb, dtype=np.float32).reshape(3, -1).T)

    return evaluate


def features(scene, seed=0, samples=8):
    """Albedo, normal and depth of every pixel, seen through glass and mirrors: what the filter goes by."""
    width, height = (int(side) for side in scene.sensors()[0].film().size())
    film = pmcip.Film(width, height, uniform=True, seed=seed)
    film.begin(samples * width * height)
    plan, sampler, context = film.plan(), points_sampler(), mi.BSDFContext()
    ray, _ = rays(scene, sampler.start(plan), plan.x, plan.y)
    n = len(plan)
    albedo, normal, depth = mi.Color3f(dr.zeros(mi.Float, n)), mi.Normal3f(0.0), mi.Float(0.0)
    active, length = dr.full(mi.Bool, True, n), dr.zeros(mi.Float, n)
    for _ in range(8):
        si = scene.ray_intersect(ray, active)
        active &= si.is_valid()
        length = dr.select(active, length + si.t, length)
        bsdf = si.bsdf(ray)
        smooth = mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        shines = dr.neq(si.emitter(scene), None) if hasattr(dr, "neq") else si.emitter(scene) != None  # noqa: E711
        ends = active & (smooth | shines)
        seen = dr.select(shines, mi.Color3f(1.0), bsdf.eval_diffuse_reflectance(si, ends))
        albedo, normal = dr.select(ends, seen, albedo), dr.select(ends, si.sh_frame.n, normal)
        depth = dr.select(ends, length, depth)
        active &= ~ends
        # On through glass where it lets light through, else along the reflection.
        onward, _ = bsdf.sample(context, si, mi.Float(0.999), mi.Point2f(0.5), active)
        ray = mi.RayDifferential3f(si.spawn_ray(si.to_world(onward.wo)))
    pixel = (plan.y.astype(np.int64) * width + plan.x.astype(np.int64))

    def mean(values):
        values = np.broadcast_to(np.asarray(values, dtype=np.float64).ravel(), n)
        total = np.bincount(pixel, values, width * height) / samples
        return np.nan_to_num(total).reshape(height, width).astype(np.float32)

    colour = lambda v: np.ascontiguousarray(np.stack([mean(v[c]) for c in range(3)], axis=-1))
    return colour(albedo), colour(normal), mean(depth)


def adaptive(scene, spp, seed=0, iterations=None):
    """A film of `spp` samples a pixel, all of them Mitsuba's."""
    width, height = (int(side) for side in scene.sensors()[0].film().size())
    film = pmcip.Film(width, height, spp=spp, seed=seed)
    film.render(radiance(scene, points_sampler()), spp, iterations=iterations or max(2, spp // 2))
    return film


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
    alone = np.array(mi.render(scene, spp=asked.spp, seed=asked.seed))[..., :3]
    film = adaptive(scene, asked.spp, asked.seed)
    pictures = {
        "Mitsuba alone": alone,
        "under pmcip": film.resolve(),
        "and filtered": film.guided(*features(scene, asked.seed)),
    }
    parts = [np.array(mi.render(scene, spp=64, seed=1000 + i)) for i in range(max(1, asked.reference_spp // 64))]
    reference = np.mean(parts, axis=0)[..., :3]
    for name, picture in pictures.items():
        error = np.mean((picture - reference) ** 2 / (reference**2 + 1e-2))
        print(f"{name:14} relMSE {error:.3e}, energy {picture.sum() / reference.sum() - 1:+.2%}")
    strip = np.concatenate([*pictures.values(), reference], axis=1)
    mi.util.write_bitmap(asked.output, mi.TensorXf(np.ascontiguousarray(strip, dtype=np.float32)), write_async=False)


if __name__ == "__main__":
    main()
