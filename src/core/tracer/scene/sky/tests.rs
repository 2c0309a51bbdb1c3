use super::*;

const SIZE: (u32, u32) = (8, 4);
const TEXELS: usize = 32;

/// A dark sky with one bright texel and one faint one far from it.
fn picture() -> [[f32; 3]; TEXELS] {
    let mut texels = [[0.0; 3]; TEXELS];
    texels[8 + 2] = [3e4; 3];
    texels[24 + 6] = [1e-4, 0.0, 0.0];
    texels
}

#[test]
fn what_shines_has_steps_and_what_does_not_has_none() {
    let texels = picture();
    let (mut rows, mut cells) = ([0; SIZE.1 as usize + 1], [0; TEXELS]);
    let power = build(SIZE, &texels, None, &mut rows, &mut cells);
    // Interpolation spreads light over the neighbours of a texel: rows 0 to 3 all have some.
    assert!(rows.windows(2).all(|pair| pair[0] < pair[1]), "{rows:?}");
    assert_eq!((rows[0], rows[4]), (0, STEPS));
    let row = &cells[8..16];
    assert_eq!(row[0], 0, "two texels west of the bright one");
    assert!(row[0] < row[1] && row[1] < row[2] && row[2] < row[3] && row[3] == STEPS, "{row:?}");
    // A cell's mean is 9/16 of its texel, and the bright row has not much less than all.
    let bright = 0.5625 * 3e4 * tables::solid_angle(8, 4, 1);
    assert!(power > bright && power < 2.0 * bright, "{power} of {bright}");
}

#[test]
fn a_black_picture_is_sampled_evenly() {
    let (mut rows, mut cells) = ([0; SIZE.1 as usize + 1], [0; TEXELS]);
    assert_eq!(build(SIZE, &[[0.0; 3]; TEXELS], None, &mut rows, &mut cells), 0.0);
    let quarter = (1.0 - core::f32::consts::FRAC_1_SQRT_2) / 2.0;
    assert!((rows[1] as f32 / STEPS as f32 - quarter).abs() < 1e-6, "{rows:?}");
    assert!(cells.chunks(8).all(|row| row[3].abs_diff(STEPS / 2) < 8 && row[7] == STEPS));
}

#[test]
fn solid_angles_add_up_to_the_sphere() {
    let sum: f32 = (0..64).map(|y| 128.0 * tables::solid_angle(128, 64, y)).sum();
    assert!((sum - 4.0 * core::f32::consts::PI).abs() < 1e-5, "{sum}");
}

#[test]
fn a_sky_that_is_none_is_refused() {
    let texels = picture();
    let (mut rows, mut cells) = ([0; SIZE.1 as usize + 1], [0; TEXELS]);
    let sun = Sun { direction: [0.0, 1.0, 0.0], radius: 0.005, radiance: [1e4; 3] };
    let power = build(SIZE, &texels, Some(&sun), &mut rows, &mut cells);
    assert!(rows[0] >= STEPS / 8, "the sun has no part");
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (width, height) = SIZE;
    let sky = Sky {
        width,
        height,
        texels: &texels,
        rows: &rows,
        cells: &cells,
        axes,
        sun: Some(sun),
        power,
        visible: true,
    };
    assert!(sky.is_valid());
    let (mut falling, mut bright) = (cells, texels);
    falling[9] = STEPS;
    bright[7][1] = f32::INFINITY;
    let wrong = [
        Sky { width: 7, ..sky },
        Sky { height: 0, ..sky },
        Sky { texels: &texels[1..], ..sky },
        Sky { texels: &bright, ..sky },
        Sky { rows: &rows[..4], ..sky },
        Sky { cells: &falling, ..sky },
        Sky { axes: [axes[0], axes[1], [0.0, 0.0, 2.0]], ..sky },
        Sky { sun: Some(Sun { radius: 0.0, ..sun }), ..sky },
        Sky { sun: Some(Sun { direction: [0.0; 3], ..sun }), ..sky },
        Sky { power: f32::NAN, ..sky },
    ];
    for (number, sky) in wrong.iter().enumerate() {
        assert!(!sky.is_valid(), "{number}");
    }
}
