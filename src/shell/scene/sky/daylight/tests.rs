use super::*;

fn day(elevation: f32) -> SkyMap {
    let (sin, cos) = elevation.to_radians().sin_cos();
    Daylight { sun: Vec3::new(cos, sin, 0.0), haze: 1.0, ground: [0.2; 3] }.sky(1.0)
}

fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// Illuminance of the ground by the sky alone, and of a surface that faces the sun, in lux.
fn illuminance(sky: &SkyMap) -> (f32, f32) {
    let half = sky.texels.len() / 2;
    let above: Vec<Vec3> = sky.texels[..half].iter().map(|texel| Vec3::from(*texel)).collect();
    let of_sun = sky.sun.map_or(0.0, |sun| luminance(sun.radiance) * sun.solid_angle());
    (luminance(irradiance(&above).to_array()), of_sun)
}

/// A clear day has about what is measured outdoors: sun of 60 to 110 klx and sky of 8 to 20 klx when the sun is
/// high (CIE and IES clear skies), civil twilight some lux.
#[test]
fn days_are_as_bright_as_days_are() {
    let (sky, sun) = illuminance(&day(60.0));
    assert!((8e3..25e3).contains(&sky) && (6e4..1.15e5).contains(&sun), "high sun: sky {sky}, sun {sun}");
    let (low_sky, low_sun) = illuminance(&day(5.0));
    assert!(low_sky < 0.5 * sky && low_sun < 0.5 * sun, "low sun: sky {low_sky}, sun {low_sun}");
    let twilight = day(-4.0);
    let (sky, _) = illuminance(&twilight);
    assert!((0.5..200.0).contains(&sky) && twilight.sun.is_none(), "twilight: {sky}");
}

/// Blue above, a low sun red, the sun's disc of its true size.
#[test]
fn days_have_the_colours_of_days() {
    let noon = day(60.0);
    let zenith = noon.texels[2 * ROWS as usize / 2];
    assert!(zenith[2] > 2.0 * zenith[0], "{zenith:?}");
    let sun = day(3.0).sun.unwrap();
    assert!(sun.radiance[0] > 3.0 * sun.radiance[2], "{sun:?}");
    assert!((2.0 * SUN_RADIUS.to_degrees() - 0.53).abs() < 1e-3);
}

/// The picture hangs as its sun does: the brightest texel is on the sun's side, and two that are equally far from the plane
/// of the sun are alike.
#[test]
fn the_picture_is_bright_where_the_sun_is() {
    let sky = day(20.0);
    let light: Vec<f32> = sky.texels.iter().map(|texel| luminance(*texel)).collect();
    let brightest = (0..light.len()).max_by(|a, b| light[*a].total_cmp(&light[*b])).unwrap();
    let columns = 2 * ROWS as usize;
    let towards = direction(brightest % columns, brightest / columns);
    assert!(towards.x > 0.9 && towards.z.abs() < 0.1, "{towards}");
    let (row, middle) = (40 * columns, columns / 4);
    let [left, right] = [light[row + middle - 31], light[row + middle + 30]];
    assert!((left / right - 1.0).abs() < 1e-3, "{left} {right}");
}
