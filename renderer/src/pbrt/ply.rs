//! Meshes in PLY files, ascii or binary, by the grammar of `ply-rs-bw`.

use std::borrow::Cow;
use std::io::{BufRead, Cursor};
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Encoding, Property, PropertyAccess, PropertyAccessResult};

use super::lexer::is_no_number;
use super::limits::{MAX_TRIANGLES, MAX_VERTICES};
use super::log::shown;
use super::parser::read_bytes;

/// Most bytes of one PLY file.
const MAX_BYTES: u64 = 1 << 30;

/// What a scene needs of a PLY file.
#[derive(Debug)]
pub(super) struct Ply {
    pub points: Vec<DVec3>,
    /// One for each point, if all have one.
    pub normals: Option<Vec<DVec3>>,
    /// The first vertex whose normal is none, because of which there are no normals.
    pub no_normal: Option<usize>,
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a PLY file; polygons become fans of triangles. The message of an error names the file.
pub(super) fn read(path: &Path) -> Result<Ply, String> {
    let bytes = read_bytes(path, MAX_BYTES).map_err(|e| e.to_string())?;
    read_bytes_as_ply(&bytes).map_err(|message| format!("{}: {message}", path.display()))
}

/// One vertex or face; other properties are dropped as they are read.
struct Element {
    position: [Option<f32>; 3],
    normal: [Option<f32>; 3],
    indices: Option<Vec<u32>>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { position: [None; 3], normal: [None; 3], indices: None }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "x" => self.position[0] = property.to_f32_lossy(),
            "y" => self.position[1] = property.to_f32_lossy(),
            "z" => self.position[2] = property.to_f32_lossy(),
            "nx" => self.normal[0] = property.to_f32_lossy(),
            "ny" => self.normal[1] = property.to_f32_lossy(),
            "nz" => self.normal[2] = property.to_f32_lossy(),
            "vertex_indices" | "vertex_index" => self.indices = property.to_u32_list(),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

fn read_bytes_as_ply(bytes: &[u8]) -> Result<Ply, String> {
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = parser.read_header(&mut reader).map_err(|e| one_line(&e))?;
    let mut ply = Ply { points: Vec::new(), normals: Some(Vec::new()), no_normal: None, triangles: Vec::new() };
    for element in header.elements.values() {
        let name = element.name.as_str();
        let left = bytes.len() as u64 - reader.get_ref().position();
        // Every element takes at least a byte, so the count cannot be taken at its word beyond that.
        if element.count as u64 > left || (element.properties.is_empty() && element.count > 0) {
            return Err(format!("{} elements {} announced, {left} bytes of data left", element.count, shown(name)));
        }
        let limit = if name == "face" { MAX_TRIANGLES } else { MAX_VERTICES };
        if matches!(name, "vertex" | "face") && element.count > limit {
            return Err(format!("{} elements {}, expected at most {limit}", element.count, shown(name)));
        }
        let mut line = String::new();
        for i in 0..element.count {
            let input = reader.get_mut();
            let read = match header.encoding {
                Encoding::Ascii => {
                    line.clear();
                    input.read_line(&mut line).map_err(|e| e.to_string())?;
                    parser.read_ascii_element(&without_words(&line), element)
                }
                Encoding::BinaryLittleEndian => parser.read_little_endian_element(input, element),
                Encoding::BinaryBigEndian => parser.read_big_endian_element(input, element),
            };
            let read = read.map_err(|e| format!("{} {i}: {}", shown(name), one_line(&e)))?;
            match name {
                "vertex" => {
                    ply.points.push(point(&read, i)?);
                    let normal = normal(&read);
                    if ply.no_normal.is_none() && normal.is_some_and(|normal| !normal.is_finite()) {
                        ply.no_normal = Some(i);
                    }
                    ply.normals =
                        ply.normals.zip(normal.filter(|normal| normal.is_finite())).map(|(mut normals, normal)| {
                            normals.push(normal);
                            normals
                        });
                }
                "face" => add_face(&mut ply.triangles, &read, i)?,
                _ => {}
            }
        }
    }
    let count = ply.points.len();
    match ply.triangles.iter().flatten().find(|&&i| i as usize >= count) {
        Some(i) => Err(format!("vertex index {i}, expected one of the {count} vertices, counted from 0")),
        None if ply.triangles.is_empty() => Err("no faces, expected a triangle mesh".to_owned()),
        None => Ok(ply),
    }
}

/// The line with a number that is too large in place of words such as "nan", which the grammar does not know: it is judged
/// by the property that it stands for.
fn without_words(line: &str) -> Cow<'_, str> {
    if !line.contains(['n', 'N']) {
        return Cow::Borrowed(line);
    }
    let words = line.split_whitespace().map(|word| if is_no_number(word) { "1e999" } else { word });
    Cow::Owned(words.collect::<Vec<_>>().join(" "))
}

fn point(element: &Element, i: usize) -> Result<DVec3, String> {
    let [Some(x), Some(y), Some(z)] = element.position else {
        return Err(format!("vertex {i} without x, y or z"));
    };
    let point = DVec3::new(x.into(), y.into(), z.into());
    if point.is_finite() { Ok(point) } else { Err(format!("vertex {i} at {x} {y} {z}, expected finite numbers")) }
}

fn normal(element: &Element) -> Option<DVec3> {
    let [x, y, z] = element.normal;
    Some(DVec3::new(x?.into(), y?.into(), z?.into()))
}

fn add_face(triangles: &mut Vec<[u32; 3]>, element: &Element, i: usize) -> Result<(), String> {
    let Some(indices) = &element.indices else {
        return Err(format!("face {i} without a list \"vertex_indices\" of whole numbers"));
    };
    let [first, rest @ ..] = indices.as_slice() else {
        return Err(format!("face {i} has no vertices"));
    };
    if rest.len() < 2 {
        return Err(format!("face {i} has {} vertices, expected at least 3", indices.len()));
    }
    if triangles.len() + rest.len() - 1 > MAX_TRIANGLES {
        return Err(format!("more than {MAX_TRIANGLES} triangles"));
    }
    triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    Ok(())
}

/// The first line of the crate's message, which quotes input in the following ones.
fn one_line(e: &ParseError) -> String {
    let text = e.to_string();
    let line = text.lines().next().unwrap_or_default().trim();
    line.chars().take(120).collect()
}
