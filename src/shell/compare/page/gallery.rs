//! The pictures of a comparison as parts of a page.

use super::super::colour::{Scale, data_uri};
use super::super::data::Comparison;
use super::super::digits::significant;
use super::super::pictures::{Gallery, Kind};
use super::super::raster::{Block, Raster};
use super::methods::named;

/// Enlargement of the zooms.
const ENLARGED: usize = 4;

/// What is written below the pictures of the methods, then of other programs: of these the seconds, since one may have several.
fn captions(comparison: &Comparison) -> Vec<String> {
    let own = comparison.shown.iter().enumerate().map(|(method, shown)| named(method, &shown.method));
    let mut captions: Vec<String> = own.collect();
    let programs = comparison.others.chunk_by(|a, b| a.name == b.name);
    for (program, others) in programs.enumerate() {
        let colour = comparison.shown.len() + program;
        captions.extend(
            others
                .iter()
                .map(|other| format!("{}, {} s", named(colour, &other.name), significant(other.seconds, 3))),
        );
    }
    captions
}

/// One row of pictures a method or another program's picture, one column a kind.
pub fn pictures(comparison: &Comparison, gallery: &Gallery) -> String {
    let spp = comparison.shown.first().map_or(0, |shown| shown.settings.spp);
    let columns = gallery.kinds.len();
    let heads: String = gallery.kinds.iter().map(|kind| head(kind, gallery.exposure)).collect();
    let cell = |kind: &Kind, row: usize, caption: &str| match kind.rasters.get(row) {
        Some(raster) => figure(raster, "", caption),
        None => "<div></div>\n".to_owned(),
    };
    let row = |(row, caption): (usize, &String)| -> String {
        gallery.kinds.iter().map(|kind| cell(kind, row, caption)).collect()
    };
    let rows: String = captions(comparison).iter().enumerate().map(row).collect();
    format!(
        "<h2>Pictures at {spp} samples a pixel</h2>\n\
         <div class='pictures' style='grid-template-columns:repeat({columns},1fr)'>\n{heads}{rows}</div>\n"
    )
}

/// A picture with further attributes and what is written below it.
fn figure(raster: &Raster, attributes: &str, caption: &str) -> String {
    let source = data_uri(raster);
    format!("<figure><img src='{source}' alt=''{attributes}><figcaption>{caption}</figcaption></figure>\n")
}

/// The title of a column, and what its colours mean.
fn head(kind: &Kind, exposure: f64) -> String {
    let meaning = match &kind.scale {
        Some(scale) => legend(scale),
        None => format!("<div class='ends'>exposure {exposure:+.1} stops</div>"),
    };
    format!("<div><h3>{} <small>{}</small></h3>{meaning}</div>\n", kind.title, kind.unit)
}

fn legend(scale: &Scale) -> String {
    let spacing = if scale.logarithmic { "logarithmic" } else { "linear" };
    format!(
        "<div class='bar' style='background:{}'></div>\
         <div class='ends'><span>{}</span><span>{spacing}</span><span>{}</span></div>",
        scale.gradient(),
        significant(scale.low, 2),
        significant(scale.high, 2)
    )
}

/// The frame around a zoomed block of the reference.
fn mark(i: usize, block: &Block, width: usize, height: usize) -> String {
    let part = |pixels: usize, of: usize| 100.0 * pixels as f64 / of as f64;
    format!(
        "<div class='mark' style='left:{:.2}%;top:{:.2}%;width:{:.2}%;aspect-ratio:1'>{}</div>",
        part(block.x, width),
        part(block.y, height),
        part(block.side, width),
        i + 1
    )
}

/// The reference, and beside it the blocks where methods differ most.
pub fn zooms(comparison: &Comparison, gallery: &Gallery) -> String {
    let reference = &gallery.reference;
    let mark = |(i, block)| mark(i, block, reference.width, reference.height);
    let marks: String = gallery.zooms.iter().enumerate().map(mark).collect();
    let strips: String =
        gallery.zooms.iter().enumerate().map(|(i, b)| strip(comparison, gallery, i, b)).collect();
    format!(
        "<h2>Where the methods differ most</h2>\n<div class='zooms'>\n\
         <figure><div class='marked'><img src='{}' alt=''>{marks}</div>\
         <figcaption>reference</figcaption></figure>\n\
         <div>\n{strips}</div>\n</div>\n\
         <p class='note'>The blocks in which the mean of e²/tvi differs most between the worst and the best \
         method, enlarged {ENLARGED} times: image above, difference to the reference below, in the colours of the \
         pictures above.</p>\n",
        data_uri(reference)
    )
}

/// A block of the reference and of all pictures.
fn strip(comparison: &Comparison, gallery: &Gallery, i: usize, block: &Block) -> String {
    let size = format!(" width='{}'", ENLARGED * block.side);
    let mut figures = figure(&gallery.reference.crop(block), &size, &format!("{}: reference", i + 1));
    for (row, caption) in captions(comparison).iter().enumerate() {
        let crops = gallery.kinds[..2].iter().map(|kind| kind.rasters[row].crop(block));
        let images: String =
            crops.map(|crop| format!("<img src='{}' alt=''{size}>\n", data_uri(&crop))).collect();
        figures += &format!("<figure>{images}<figcaption>{caption}</figcaption></figure>\n");
    }
    format!("<div class='strip'>\n{figures}</div>\n")
}
