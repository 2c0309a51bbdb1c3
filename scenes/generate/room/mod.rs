//! The room: a living room in the evening, lit by a dozen lamps from a ceiling panel to a standby light.

mod furniture;
mod lamps;
mod plants;
mod set;
mod shelf;
mod shell;
mod sofa;
mod tableware;
mod textiles;
mod textures;

use super::shapes::at;
use super::writer::Files;
use set::Set;
use std::io::Result;

/// The sources that the room depends on.
pub const SOURCES: &str = concat!(
    include_str!("mod.rs"),
    include_str!("furniture.rs"),
    include_str!("lamps.rs"),
    include_str!("plants.rs"),
    include_str!("set.rs"),
    include_str!("shelf.rs"),
    include_str!("shell.rs"),
    include_str!("sofa.rs"),
    include_str!("tableware.rs"),
    include_str!("textiles.rs"),
    include_str!("textures.rs"),
    include_str!("materials.mtl"),
    include_str!("../shapes.rs"),
);

/// Cells of soft solids in metres at detail 1.
const STEP: f32 = 0.016;

/// Materials, textures, and an OBJ file for each thing that stands by itself.
///
/// # Errors
/// If a texture cannot be encoded.
pub fn files(detail: f32) -> Result<Files> {
    let mut files = Files::default();
    files.add_text("materials.mtl", include_str!("materials.mtl"));
    let images = [
        ("parquet", textures::parquet()),
        ("walnut", textures::walnut()),
        ("weave", textures::weave()),
        ("wallpaper", textures::wallpaper()),
        ("carpet", textures::carpet()),
        ("books", textures::books()),
        ("landscape", textures::landscape()),
    ];
    for (name, image) in &images {
        files.add_png(name, image)?;
    }
    for (name, set) in sets(detail) {
        set.write(&mut files, name);
    }
    Ok(files)
}

/// The meshes by file. Lamps that may move stand at their own origin; the scene file places them.
fn sets(detail: f32) -> Vec<(&'static str, Set)> {
    let step = STEP / detail;
    let shelf = at(1.70, 0.0, shell::LOW.z + 0.17);
    let [dining, coffee, _] = furniture::PLACES;
    let mut things = Set::default();
    things.place_all(&shelf::build(), shelf);
    things.place_all(&tableware::dining(), at(dining.x, furniture::HEIGHTS[0], dining.z));
    things.place_all(&tableware::coffee(step), at(coffee.x, furniture::HEIGHTS[1], coffee.z));
    things.place_all(&tableware::floor_vase(), at(0.62, 0.0, -1.15));
    let mut plants = Set::default();
    plants.place_all(&plants::fig(), at(-2.30, 0.0, -1.10));
    plants.place_all(&plants::trailing(), shelf * at(-0.55, 2.05, 0.06));
    vec![
        ("shell", shell::build()),
        ("furniture", furniture::build()),
        ("sofa", sofa::build(step)),
        ("things", things),
        ("textiles", textiles::build(detail)),
        ("plants", plants),
        ("fixed-lamps", lamps::fixed(shelf)),
        ("floor-lamp", lamps::floor_lamp()),
        ("table-lamp", lamps::table_lamp()),
        ("pendant", lamps::pendant()),
        ("candles", lamps::candles()),
    ]
}
