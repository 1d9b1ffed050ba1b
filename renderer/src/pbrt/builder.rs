//! Directives to a scene: the graphics state and what each directive does to it.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec3};
use mislab_kernel::request::Settings;
use mislab_kernel::request::scene::{Camera, Light, Scene, Shape};

use super::log::{Log, Pos, shown, suggestion};
use super::material::{Materials, read_bsdf};
use super::params::{Params, named, nothing, numbers, single_name};
use super::parser::Directive;
use super::shape::{Placement, read_area_light, read_shape};
use super::transform::{Transform, flaw};
use super::{SceneFile, header};
use crate::error::Error;

/// Most `AttributeBegin` inside each other.
const MAX_DEPTH: usize = 1000;
/// Most shapes of a scene.
const MAX_SHAPES: usize = 1 << 20;

/// Largest number in the camera's matrix, and in the inverse of its volume.
const MAX_CAMERA: f64 = 1e15;

/// What can stand in a scene file, for suggestions.
const DIRECTIVES: [&str; 31] = [
    "AreaLightSource",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Include",
    "Integrator",
    "LookAt",
    "MakeNamedMaterial",
    "Material",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "SurfaceIntegrator",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "Translate",
    "WorldBegin",
    "WorldEnd",
];

/// pbrt's graphics state, saved and restored by `AttributeBegin` and `AttributeEnd`.
#[derive(Clone)]
struct State {
    /// World (in the header: camera) from object: pbrt's current transformation matrix.
    ctm: Transform,
    /// `None`: no material given.
    material: Option<usize>,
    /// Radiance of the shapes to come.
    area_light: Option<Vec3>,
    reverse_orientation: bool,
    /// Inside `ObjectBegin`, whose shapes are seen only through `ObjectInstance`.
    in_object: bool,
}

/// The kinds of blocks, and how they are closed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    Attribute,
    Transform,
    Object,
}

impl Block {
    fn name(self) -> &'static str {
        match self {
            Self::Attribute => "Attribute",
            Self::Transform => "Transform",
            Self::Object => "Object",
        }
    }
}

struct Saved {
    block: Block,
    at: Pos,
    state: State,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Header,
    World,
    Done,
}

/// What the directives so far have said.
pub(super) struct Builder {
    phase: Phase,
    state: State,
    saved: Vec<Saved>,
    coordinate_systems: HashMap<String, Transform>,
    settings: Settings,
    film_filename: Option<String>,
    camera: Option<Camera>,
    materials: Materials,
    shapes: Vec<Shape>,
    lights: usize,
    /// Some directive was one of pbrt's.
    recognised: bool,
}

impl Default for Builder {
    fn default() -> Self {
        let state = State {
            ctm: Transform::IDENTITY,
            material: None,
            area_light: None,
            reverse_orientation: false,
            in_object: false,
        };
        Self {
            phase: Phase::Header,
            state,
            saved: Vec::new(),
            coordinate_systems: HashMap::new(),
            settings: Settings::default(),
            film_filename: None,
            camera: None,
            materials: Materials::default(),
            shapes: Vec::new(),
            lights: 0,
            recognised: false,
        }
    }
}

impl Builder {
    /// Does what one directive says.
    pub fn apply(&mut self, d: Directive, log: &mut Log) -> Result<(), Error> {
        if self.phase == Phase::Done {
            log.warn_once("after WorldEnd", d.at, "what follows WorldEnd is not read");
            return Ok(());
        }
        self.recognised |= DIRECTIVES.contains(&d.name.as_str());
        let at = d.at;
        match d.name.as_str() {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform"
            | "CoordinateSystem" | "CoordSysTransform" => self.transformation(&d, log),
            "Film" | "Sampler" | "PixelFilter" | "Integrator" | "SurfaceIntegrator" | "Camera" => {
                if self.phase == Phase::World {
                    let message = format!("{} belongs before WorldBegin; it is read all the same", d.name);
                    log.warn_once(&format!("late {}", d.name), at, message);
                }
                let name = d.name.clone();
                let (kind, params) = named(d, log)?;
                self.header_directive(&name, &kind, params, at, log)
            }
            "WorldBegin" => {
                nothing(&d, log)?;
                if self.phase != Phase::Header {
                    return Err(log.error(at, "WorldBegin inside the world, expected one WorldBegin"));
                }
                self.phase = Phase::World;
                self.state.ctm = Transform::IDENTITY;
                self.coordinate_systems.insert("world".to_owned(), Transform::IDENTITY);
                Ok(())
            }
            "WorldEnd" => {
                nothing(&d, log)?;
                if self.phase != Phase::World {
                    return Err(log.error(at, "WorldEnd without WorldBegin"));
                }
                self.warn_unclosed(log);
                self.phase = Phase::Done;
                Ok(())
            }
            "AttributeBegin" => nothing(&d, log).and_then(|()| self.begin(Block::Attribute, at, log)),
            "AttributeEnd" => nothing(&d, log).and_then(|()| self.end(Block::Attribute, at, log)),
            "TransformBegin" => nothing(&d, log).and_then(|()| self.begin(Block::Transform, at, log)),
            "TransformEnd" => nothing(&d, log).and_then(|()| self.end(Block::Transform, at, log)),
            "ObjectBegin" => {
                log.warn_once("objects", at, "ObjectBegin, ObjectInstance: instances are not supported and left out");
                self.begin(Block::Object, at, log)?;
                self.state.in_object = true;
                Ok(())
            }
            "ObjectEnd" => self.end(Block::Object, at, log),
            "ObjectInstance" => {
                log.warn_once("objects", at, "ObjectBegin, ObjectInstance: instances are not supported and left out");
                Ok(())
            }
            "ReverseOrientation" => {
                nothing(&d, log)?;
                self.state.reverse_orientation = !self.state.reverse_orientation;
                Ok(())
            }
            "Material" => {
                let (kind, params) = named(d, log)?;
                let bsdf = read_bsdf(&kind, params, at, log)?;
                self.state.material = Some(self.materials.define_unnamed(bsdf));
                Ok(())
            }
            "MakeNamedMaterial" => {
                let (name, mut params) = named(d, log)?;
                let Some(kind) = params.text("type", log)? else {
                    let message = format!("MakeNamedMaterial {} without \"string type\"", shown(&name));
                    return Err(log.error(at, message));
                };
                let bsdf = read_bsdf(&kind.value, params, at, log)?;
                self.materials.define_named(name, bsdf, at, log);
                Ok(())
            }
            "NamedMaterial" => {
                let name = single_name(&d, log)?;
                self.state.material = Some(self.materials.find(&name, at, log)?);
                Ok(())
            }
            "AreaLightSource" => {
                let (kind, params) = named(d, log)?;
                self.state.area_light = read_area_light(&kind, params, at, log)?;
                Ok(())
            }
            "Shape" => self.shape(d, log),
            unknown => {
                let key = format!("directive {unknown}");
                if log.has_said(&key) {
                    return Ok(());
                }
                let guess = suggestion(unknown, &DIRECTIVES);
                let message = format!("directive {} is not supported and left out{guess}", shown(unknown));
                log.warn_once(&key, at, message);
                Ok(())
            }
        }
    }

    fn header_directive(
        &mut self,
        name: &str,
        kind: &str,
        params: Params,
        at: Pos,
        log: &mut Log,
    ) -> Result<(), Error> {
        match name {
            "Film" => self.film_filename = Some(header::film(kind, params, at, &mut self.settings, log)?),
            "Sampler" => header::sampler(kind, params, at, &mut self.settings, log)?,
            "PixelFilter" => header::pixel_filter(kind, params, at, log)?,
            "Camera" => {
                let world_from_camera = self.state.ctm.inverted();
                let (matrix, max) = (world_from_camera.matrix, MAX_CAMERA);
                let largest = matrix.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                if largest > max || matrix.determinant().abs() < 1.0 / max {
                    let message = "Camera under a transformation that scales or moves it too far";
                    return Err(log.error(at, format!("{message}, expected factors and distances up to {max:e}")));
                }
                self.camera = Some(header::camera(kind, params, at, matrix, log)?);
                self.coordinate_systems.insert("camera".to_owned(), world_from_camera);
            }
            _ => header::integrator(kind, params, at, &mut self.settings, log)?,
        }
        Ok(())
    }

    fn transformation(&mut self, d: &Directive, log: &mut Log) -> Result<(), Error> {
        let ctm = self.state.ctm;
        let degenerate = |message: &str| log.error(d.at, format!("{}: {message}", d.name));
        let new = match d.name.as_str() {
            "Identity" => {
                nothing(d, log)?;
                Transform::IDENTITY
            }
            "Translate" => ctm * Transform::translate(DVec3::from_array(numbers(d, log)?)),
            "Scale" => ctm * Transform::scale(DVec3::from_array(numbers(d, log)?)),
            "Rotate" => {
                let [degrees, axis @ ..] = numbers::<4>(d, log)?;
                let turn = Transform::rotate(degrees, DVec3::from_array(axis));
                ctm * turn.ok_or_else(|| degenerate("axis 0 0 0, expected a direction"))?
            }
            "LookAt" => {
                let v = numbers::<9>(d, log)?;
                let [eye, look, up] = [0, 3, 6].map(|i| DVec3::from_slice(&v[i..i + 3]));
                let view = Transform::look_at(eye, look, up);
                ctm * view.ok_or_else(|| {
                    degenerate("expected eye and target apart, and an up direction not along the line between them")
                })?
            }
            "Transform" => Transform::from_matrix(DMat4::from_cols_array(&numbers(d, log)?)),
            "ConcatTransform" => ctm * Transform::from_matrix(DMat4::from_cols_array(&numbers(d, log)?)),
            "CoordinateSystem" => {
                self.coordinate_systems.insert(single_name(d, log)?, ctm);
                return Ok(());
            }
            _ => {
                let name = single_name(d, log)?;
                let Some(system) = self.coordinate_systems.get(&name) else {
                    let message = format!("CoordSysTransform {}: no CoordinateSystem of that name", shown(&name));
                    return Err(log.error(d.at, message));
                };
                *system
            }
        };
        if let Some(flaw) = flaw(&new) {
            return Err(log.error(d.at, format!("{} gives {flaw}", d.name)));
        }
        self.state.ctm = new;
        Ok(())
    }

    fn begin(&mut self, block: Block, at: Pos, log: &Log) -> Result<(), Error> {
        if self.saved.len() >= MAX_DEPTH {
            return Err(log.error(at, format!("blocks inside each other, expected at most {MAX_DEPTH} deep")));
        }
        self.saved.push(Saved { block, at, state: self.state.clone() });
        Ok(())
    }

    fn end(&mut self, block: Block, at: Pos, log: &Log) -> Result<(), Error> {
        let name = block.name();
        let Some(saved) = self.saved.pop() else {
            return Err(log.error(at, format!("{name}End without {name}Begin")));
        };
        if saved.block != block {
            let (open, line) = (saved.block.name(), log.locate(saved.at).line);
            return Err(log.error(at, format!("{name}End, expected {open}End for the {open}Begin of line {line}")));
        }
        if block == Block::Transform {
            self.state.ctm = saved.state.ctm;
        } else {
            self.state = saved.state;
        }
        Ok(())
    }

    fn warn_unclosed(&mut self, log: &mut Log) {
        for saved in std::mem::take(&mut self.saved) {
            log.warn_once("unclosed", saved.at, format!("{}Begin is never closed", saved.block.name()));
        }
    }

    fn shape(&mut self, d: Directive, log: &mut Log) -> Result<(), Error> {
        let at = d.at;
        if self.phase == Phase::Header {
            return Err(log.error(at, "Shape before WorldBegin, expected after it"));
        }
        if self.shapes.len() >= MAX_SHAPES {
            return Err(log.error(at, format!("one Shape too many, expected at most {MAX_SHAPES}")));
        }
        let folders = d.folders.clone();
        let (kind, params) = named(d, log)?;
        let place = Placement {
            world_from_object: &self.state.ctm.matrix,
            reverse: self.state.reverse_orientation,
            folders: &folders,
        };
        let Some(surface) = read_shape(&kind, params, at, &place, log)? else { return Ok(()) };
        if self.state.in_object {
            return Ok(());
        }
        let (material, light) = match self.state.area_light {
            None => (Some(self.materials.use_for_shape(self.state.material)), None),
            Some(radiance) => {
                self.lights += 1;
                let light = Light { name: format!("light{}", self.lights), radiance, on: true };
                (self.materials.use_for_light(self.state.material), Some(light))
            }
        };
        let reverse_orientation = surface.reverse_orientation;
        self.shapes.push(Shape { geometry: surface.geometry, reverse_orientation, material, light });
        Ok(())
    }

    /// The scene, once all directives are read. `end` is where the file ends.
    pub fn finish(mut self, name: String, source: String, log: &mut Log, end: Pos) -> Result<SceneFile, Error> {
        if !self.recognised {
            return Err(log.error(Pos { offset: 0, ..end }, "no pbrt directive found, expected a pbrt-v3 scene file"));
        }
        match self.phase {
            Phase::Header => log.warn(end, "no WorldBegin: the scene is empty"),
            Phase::World => log.warn(end, "no WorldEnd: the file may be incomplete"),
            Phase::Done => {}
        }
        self.warn_unclosed(log);
        let camera = self.camera.unwrap_or_else(|| {
            log.warn(end, "no Camera: seen from the origin along +z with a field of view of 90 degrees, as in pbrt");
            Camera { world_from_camera: DMat4::IDENTITY, fov_deg: 90.0, screen_window: None }
        });
        let (materials, index) = self.materials.finish();
        for shape in &mut self.shapes {
            shape.material = shape.material.and_then(|i| index[i]);
        }
        Ok(SceneFile {
            scene: Scene { name, camera, materials, shapes: self.shapes },
            settings: self.settings,
            film_filename: self.film_filename.unwrap_or_else(|| "pbrt.exr".to_owned()),
            warnings: log.take_warnings(),
            source,
        })
    }
}
