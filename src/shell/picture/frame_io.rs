//! Pictures on disk: EXR for numbers, PNG for eyes.
//!
//! EXR files hold linear Rec. 709 radiance as `R G B` beside further 32-bit float channels, ZIP compressed, with
//! every setting as a text attribute. The same picture always makes the same bytes. Any flat EXR can be read
//! (half or float, scan lines or tiles) if one of its parts has the channels `R`, `G` and `B`; names with a
//! prefix, such as `ViewLayer.Combined.R`, count if there is no plain one.

use crate::error::Error;
use crate::picture::output;
use crate::scene::openexr;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    ReadChannels, ReadLayers, Text, WritableImage,
};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Write};
use std::path::Path;

/// Attributes of ours begin with this, so that no other program's are taken for them.
const PREFIX: &str = "pmcip:";

/// A linear picture with further planes and the settings it was made with. Planes are rows from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB.
    pub rgb: Vec<[f32; 3]>,
    /// Further planes by channel name, such as `variance`, `count` and `kernel.weight`.
    pub planes: BTreeMap<String, Vec<f32>>,
    /// Settings by name.
    pub attributes: BTreeMap<String, String>,
}

impl Picture {
    /// Pixels with a colour that is infinite or not a number.
    pub fn broken_pixels(&self) -> usize {
        self.rgb.iter().filter(|rgb| rgb.iter().any(|v| !v.is_finite())).count()
    }
}

/// Writes an EXR file.
///
/// # Errors
/// [`Error::Write`]; no partial file is left.
pub fn write_exr(path: &Path, picture: &Picture) -> Result<(), Error> {
    let bytes = encode_exr(picture).map_err(|reason| Error::write(path, reason))?;
    output::write(path, |file| file.write_all(&bytes))
}

/// The bytes of an EXR file.
fn encode_exr(picture: &Picture) -> exr::error::Result<Vec<u8>> {
    let size = (picture.width as usize, picture.height as usize);
    let attributes = LayerAttributes {
        other: picture
            .attributes
            .iter()
            .map(|(name, value)| (text(&[PREFIX, name]), AttributeValue::Text(text(&[value]))))
            .collect(),
        software_name: Some(text(&["pmcip ", env!("CARGO_PKG_VERSION")])),
        ..LayerAttributes::default()
    };
    let colours = ["R", "G", "B"].into_iter().enumerate();
    let colours = colours.map(|(i, name)| channel(name, picture.rgb.iter().map(|pixel| pixel[i]).collect()));
    let planes = picture.planes.iter().map(|(name, values)| channel(name, values.clone()));
    let channels = AnyChannels::sort(colours.chain(planes).collect());
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

fn channel(name: &str, values: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(text(&[name]), FlatSamples::F32(values))
}

/// EXR text is bytes; today's programs read them as UTF-8.
fn text(parts: &[&str]) -> Text {
    Text::from_slice_unchecked(parts.concat().as_bytes())
}

/// Puts the header's attributes into the order of their names: the `exr` crate keeps them in a hash map, which
/// orders them differently in every run. No length changes, so the file's offsets stay true.
fn sort_attributes(file: &mut [u8]) {
    const MAGIC_AND_VERSION: usize = 8;
    let mut attributes = Vec::new();
    let mut rest = &file[MAGIC_AND_VERSION..];
    while rest[0] != 0 {
        let (attribute, after) = rest.split_at(attribute_length(rest));
        attributes.push(attribute);
        rest = after;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[MAGIC_AND_VERSION..][..sorted.len()].copy_from_slice(&sorted);
}

/// Bytes of an attribute: its name and its type, each ended by a zero, the length of its value, its value.
fn attribute_length(bytes: &[u8]) -> usize {
    let mut zeros = bytes.iter().enumerate().filter(|(_, byte)| **byte == 0).map(|(at, _)| at);
    let value = zeros.nth(1).map_or(bytes.len(), |at| at + 5);
    let length: [u8; 4] = bytes[value - 4..value].try_into().unwrap_or_default();
    value + u32::from_le_bytes(length) as usize
}

/// Reads an EXR file: colours, the other channels of the same part, and attributes of ours.
///
/// # Errors
/// [`Error::Read`] if the file is missing, damaged, has only deep data or no `R`, `G` and `B`, or claims more pixels than a
/// file of its length can hold.
pub fn read_exr(path: &Path) -> Result<Picture, Error> {
    let file = File::open(path).map_err(|reason| Error::read(path, output::plain(&reason)))?;
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let image = openexr::read(file, |_| Ok(()), reader.all_attributes())
        .map_err(|reason| Error::read(path, reason))?;
    let found = image.layer_data.iter().find_map(|layer| Some((layer, colour_prefix(&layer.channel_data)?)));
    let (layer, prefix) = found.ok_or_else(|| Error::read(path, "it has no channels R, G and B"))?;
    to_picture(layer, &prefix).ok_or_else(|| Error::read(path, "its channels are subsampled"))
}

/// Reads the attributes of ours from the head of an EXR file.
///
/// # Errors
/// [`Error::Read`] if the file is missing or no EXR file.
pub fn read_attributes(path: &Path) -> Result<BTreeMap<String, String>, Error> {
    let file = File::open(path).map_err(|reason| Error::read(path, output::plain(&reason)))?;
    let head = exr::meta::MetaData::read_from_buffered(BufReader::new(file), false)
        .map_err(|reason| Error::read(path, reason))?;
    Ok(head.headers.first().map(|header| ours(&header.own_attributes)).unwrap_or_default())
}

/// Attributes of ours, without their prefix.
fn ours(attributes: &LayerAttributes) -> BTreeMap<String, String> {
    let ours = attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(value) => Some((name.to_string().strip_prefix(PREFIX)?.to_owned(), utf8(value))),
        _ => None,
    });
    ours.collect()
}

/// What stands before `R`, `G` and `B` in a part's channel names, preferably nothing.
fn colour_prefix(channels: &AnyChannels<FlatSamples>) -> Option<String> {
    let names: Vec<String> = channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let prefixes = names.iter().filter_map(|name| name.strip_suffix('R'));
    let complete =
        prefixes.filter(|prefix| ["G", "B"].iter().all(|c| names.contains(&format!("{prefix}{c}"))));
    complete.min_by_key(|prefix| prefix.len()).map(String::from)
}

fn to_picture(layer: &Layer<AnyChannels<FlatSamples>>, prefix: &str) -> Option<Picture> {
    let pixels = layer.size.area();
    let mut planes: BTreeMap<String, Vec<f32>> = layer
        .channel_data
        .list
        .iter()
        .filter(|channel| channel.sample_data.len() == pixels)
        .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
        .collect();
    let [r, g, b] = ["R", "G", "B"].map(|colour| planes.remove(&format!("{prefix}{colour}")));
    let rgb = r?.into_iter().zip(g?).zip(b?).map(|((r, g), b)| [r, g, b]).collect();
    let (width, height) = (layer.size.x() as u32, layer.size.y() as u32);
    Some(Picture { width, height, rgb, attributes: ours(&layer.attributes), planes })
}

fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

/// Writes a PNG file: `exposure` in stops (2^exposure times brighter), sRGB transfer, 8 bits.
///
/// # Errors
/// [`Error::Write`]; no partial file is left.
pub fn write_png(path: &Path, picture: &Picture, exposure: f32) -> Result<(), Error> {
    let scale = exposure.exp2();
    let pixels: Vec<u8> = picture.rgb.iter().flatten().map(|value| encode_srgb(value * scale)).collect();
    let mut bytes = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut bytes,
        &pixels,
        picture.width,
        picture.height,
        image::ExtendedColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .map_err(|reason| Error::write(path, reason))?;
    output::write(path, |file: &mut File| -> io::Result<()> { file.write_all(&bytes.into_inner()) })
}

/// The sRGB code of a linear value; what is not a number becomes black.
pub(crate) fn encode_srgb(linear: f32) -> u8 {
    let value = linear.clamp(0.0, 1.0);
    let coded = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
    (coded * 255.0 + 0.5) as u8
}
