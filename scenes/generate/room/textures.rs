//! Textures, painted by formula. Colours here are as on the screen (sRGB).

use super::super::noise::{between, fractal, hash, value};
use super::shelf::BOOKS;
use glam::{Vec3, vec3};
use image::{Rgb, RgbImage};
use std::f32::consts::TAU;

/// An image of a function of the unit square, v upwards.
fn paint(width: u32, height: u32, colour: impl Fn(f32, f32) -> Vec3) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / width as f32, 1.0 - (y as f32 + 0.5) / height as f32);
        Rgb((colour(u, v).clamp(Vec3::ZERO, Vec3::ONE) * 255.0 + 0.5).as_u8vec3().to_array())
    })
}

/// Noise that repeats over the unit square: on a torus, `rate` periods around.
fn tiled(u: f32, v: f32, rate: (f32, f32), octaves: u32) -> f32 {
    let (a, b) = (TAU * u, TAU * v);
    let p = vec3(a.cos() * rate.0, a.sin() * rate.0 + b.cos() * rate.1, b.sin() * rate.1 + 0.3 * a.cos());
    fractal(p, octaves)
}

/// Planks of oak, eight across, each with its own tone, laid with joints.
pub fn parquet() -> RgbImage {
    const ROWS: f32 = 10.0;
    paint(512, 512, |u, v| {
        let row = (v * ROWS).floor();
        let shift = hash(row as u32);
        let along = (u + shift) * 2.0;
        let plank = row as u32 * 7 + (along.floor() as u32 % 2);
        let tone = between(plank + 40, 0.80, 1.12);
        let grain = fractal(vec3(u * 9.0 + 31.0 * hash(plank), v * 190.0, plank as f32), 3);
        let rings = (26.0 * (v * 3.0 + 0.25 * fractal(vec3(3.0 * u, 9.0 * v, plank as f32 + 9.0), 2))).sin();
        let (fx, fy) = (along.fract(), (v * ROWS).fract());
        let gap = if !(0.03..=0.97).contains(&fy) || !(0.003..=0.997).contains(&fx) { 0.45 } else { 1.0 };
        vec3(0.62, 0.43, 0.27) * tone * gap * (1.0 + 0.10 * grain + 0.05 * rings)
    })
}

/// Walnut: dark streaks.
pub fn walnut() -> RgbImage {
    paint(256, 256, |u, v| {
        let bend = 0.06 * tiled(u, v, (0.6, 0.6), 2);
        let streak = tiled(u, v + bend, (0.5, 9.0), 3);
        vec3(0.46, 0.30, 0.19) * (1.0 + 0.22 * streak)
    })
}

/// A weave of warp and weft.
pub fn weave() -> RgbImage {
    const THREADS: f32 = 32.0;
    paint(256, 256, |u, v| {
        let (x, y) = (u * THREADS, v * THREADS);
        let over = (x.floor() + y.floor()).rem_euclid(2.0) < 1.0;
        let (across, along) = if over { (x.fract(), y.fract()) } else { (y.fract(), x.fract()) };
        let round =
            (std::f32::consts::PI * across).sin() * (0.75 + 0.25 * (std::f32::consts::PI * along).sin());
        Vec3::splat(0.72 + 0.26 * round + 0.05 * value(vec3(40.0 * u, 40.0 * v, 0.5)))
    })
}

/// Wallpaper: leaves on a diagonal lattice, tone on tone.
pub fn wallpaper() -> RgbImage {
    paint(256, 256, |u, v| {
        let cell = |x: f32, y: f32| {
            let (x, y) = ((x.rem_euclid(1.0)) - 0.5, (y.rem_euclid(1.0)) - 0.5);
            let leaf = |s: f32| {
                let (a, b) = (x * 0.8 + s * y * 0.6, y * 0.8 - s * x * 0.6 - 0.06);
                (a / 0.07).powi(2) + (b / 0.20).powi(2) < 1.0 && (a.abs() > 0.007)
            };
            leaf(1.0) || leaf(-1.0) || (x / 0.045).powi(2) + ((y + 0.30) / 0.045).powi(2) < 1.0
        };
        let figure = cell(2.0 * u, 2.0 * v) || cell(2.0 * u + 0.5, 2.0 * v + 0.5);
        let ground = vec3(0.37, 0.47, 0.45) * (1.0 + 0.02 * value(vec3(90.0 * u, 90.0 * v, 0.0)));
        if figure { ground * 1.16 + vec3(0.03, 0.025, 0.0) } else { ground }
    })
}

/// A carpet: border with triangles, field of diamonds, a medallion.
pub fn carpet() -> RgbImage {
    let (cream, red, blue, ochre) =
        (vec3(0.86, 0.80, 0.68), vec3(0.62, 0.24, 0.17), vec3(0.16, 0.22, 0.34), vec3(0.80, 0.57, 0.26));
    paint(320, 224, |u, v| {
        let (x, y) = ((u - 0.5).abs() * 2.7, (v - 0.5).abs() * 1.9);
        let edge = (1.35 - x).min(0.95 - y);
        let along = if 1.35 - x < 0.95 - y { y } else { x };
        let saw = ((along * 9.0).fract() - 0.5).abs() * 2.0;
        let diamond = ((x * 5.0).fract() - 0.5).abs() + ((y * 5.0).fract() - 0.5).abs();
        let medallion = x / 0.62 + y / 0.46;
        match edge {
            e if e < 0.03 => blue,
            e if e < 0.06 => cream,
            e if e < 0.20 => {
                if (e - 0.06) / 0.14 < saw {
                    red
                } else {
                    ochre
                }
            }
            e if e < 0.23 => cream,
            e if e < 0.25 => blue,
            _ if medallion < 0.30 => ochre,
            _ if medallion < 0.42 => blue,
            _ if medallion < 0.85 => {
                if diamond < 0.28 {
                    ochre
                } else {
                    red
                }
            }
            _ if medallion < 0.95 => cream,
            _ if diamond < 0.16 => ochre,
            _ if diamond < 0.30 => red,
            _ => blue,
        }
    })
}

/// Spines of books side by side: cloth, bands and a label.
pub fn books() -> RgbImage {
    let tones = [
        vec3(0.45, 0.16, 0.13),
        vec3(0.14, 0.22, 0.33),
        vec3(0.22, 0.32, 0.25),
        vec3(0.72, 0.55, 0.28),
        vec3(0.80, 0.74, 0.62),
        vec3(0.32, 0.22, 0.18),
        vec3(0.62, 0.34, 0.22),
        vec3(0.28, 0.30, 0.34),
    ];
    paint(512, 128, |u, v| {
        let kind = (u * BOOKS as f32).floor() as u32;
        let across = (u * BOOKS as f32).fract();
        let cloth = tones[(hash(kind + 900) * tones.len() as f32) as usize] * between(kind + 950, 0.8, 1.15);
        let gold = vec3(0.86, 0.70, 0.36);
        let at = between(kind + 970, 0.62, 0.78);
        let band = [0.08, 0.92, at - 0.14, at + 0.14].into_iter().any(|b| (v - b).abs() < 0.012);
        let letters = (v - at).abs() < 0.10
            && (across - 0.5).abs() < 0.22
            && hash((v * 64.0) as u32 * 57 + (across * 12.0) as u32 + kind * 7919) > 0.45;
        if (band || letters) && across > 0.06 { gold } else { cloth }
    })
}

/// A landscape: hills in mist under a low sun.
pub fn landscape() -> RgbImage {
    paint(384, 248, |u, v| {
        let sky = vec3(0.93, 0.74, 0.50).lerp(vec3(0.36, 0.52, 0.60), ((v - 0.35) * 1.7).clamp(0.0, 1.0));
        let sun = (u - 0.66).hypot((v - 0.63) * 0.65);
        let mut colour = if sun < 0.055 {
            vec3(1.0, 0.93, 0.75)
        } else {
            sky + vec3(0.18, 0.12, 0.02) * (-9.0 * sun).exp()
        };
        for i in 0..5u32 {
            let depth = i as f32 / 4.0;
            let line = 0.55 - 0.46 * depth
                + (0.05 + 0.05 * depth) * fractal(vec3(u * (3.0 + 2.0 * depth), 7.0 * i as f32, 0.0), 4);
            if v < line {
                let mist = 0.25 * ((line - v) / 0.2).min(1.0);
                colour = vec3(0.55, 0.60, 0.58).lerp(vec3(0.13, 0.22, 0.20), depth)
                    + mist * vec3(0.5, 0.4, 0.3) * (1.0 - depth);
            }
        }
        colour * (1.0 + 0.06 * fractal(vec3(60.0 * u, 40.0 * v, 3.0), 2))
    })
}
