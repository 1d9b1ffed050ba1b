//! Directives to a scene: the graphics state and what each directive does to it.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec3};
use mislab_kernel::request::Settings;
use mislab_kernel::request::scene::{Camera, Light, Scene, Shape};

use super::directives::{DIRECTIVES, OF_V4, SETTINGS};
use super::log::{Log, Pos, shown};
use super::material::{Materials, read_bsdf};
use super::params::{Params, named, nothing, numbers, single_name};
use super::parser::Directive;
use super::same_place::warn_of_twins;
use super::shape::{Placement, enlarge, read_area_light, read_shape};
use super::transform::{Transform, flaw};
use super::{SceneFile, header};
use crate::error::Error;
use crate::near::{near, suggestion};

/// Most `AttributeBegin` inside each other.
const MAX_DEPTH: usize = 100_000;
/// Said once of blocks that are closed in another order than they were opened.
const CROSSED: &str = "crossed blocks";
/// Most shapes of a scene.
const MAX_SHAPES: usize = 1 << 20;

/// Largest number in the camera's matrix, and in the inverse of its volume.
const MAX_CAMERA: f64 = 1e15;

/// pbrt's graphics state, saved and restored by `AttributeBegin` and `AttributeEnd` with the current transformation.
#[derive(Clone, Copy, Default)]
struct Graphics {
    /// `None`: no material given.
    material: Option<Surface>,
    /// Radiance of the shapes to come.
    area_light: Option<Vec3>,
    reverse_orientation: bool,
}

/// What shapes are made of.
#[derive(Clone, Copy)]
enum Surface {
    /// A material, by its definition.
    Made(usize),
    /// pbrt's material "" or "none": nothing is there but a border between media.
    Nothing,
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

#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Header,
    World,
    Done,
}

/// What the directives so far have said.
pub(super) struct Builder {
    phase: Phase,
    /// World (in the header: camera) from object: pbrt's current transformation matrix.
    ctm: Transform,
    graphics: Graphics,
    /// As in pbrt-v3 there are two stacks that know nothing of each other, and so files whose blocks are crossed mean
    /// the same here as there.
    saved_graphics: Vec<Graphics>,
    saved_transforms: Vec<Transform>,
    /// The blocks that are open and where they begin, for messages.
    open: Vec<(Block, Pos)>,
    /// Inside `ObjectBegin`, whose shapes are seen only through `ObjectInstance`.
    in_object: bool,
    coordinate_systems: HashMap<String, Transform>,
    settings: Settings,
    film_filename: Option<String>,
    foreign_integrator: Option<String>,
    /// The file asks for one strategy and then for another.
    strategy_replaced: bool,
    /// And for one Film and then for another.
    film_replaced: bool,
    has_sampler: bool,
    has_integrator: bool,
    /// Where each of [`SETTINGS`] stands, for messages.
    settings_at: HashMap<String, (Pos, String)>,
    camera: Option<Camera>,
    materials: Materials,
    shapes: Vec<Shape>,
    /// Where the shapes stand in the file.
    places: Vec<Pos>,
    lights: usize,
    /// Some directive was one of pbrt's.
    recognised: bool,
}

impl Default for Builder {
    fn default() -> Self {
        Self {
            phase: Phase::Header,
            ctm: Transform::IDENTITY,
            graphics: Graphics::default(),
            saved_graphics: Vec::new(),
            saved_transforms: Vec::new(),
            open: Vec::new(),
            in_object: false,
            coordinate_systems: HashMap::new(),
            settings: Settings::default(),
            film_filename: None,
            foreign_integrator: None,
            strategy_replaced: false,
            film_replaced: false,
            has_sampler: false,
            has_integrator: false,
            settings_at: HashMap::new(),
            camera: None,
            materials: Materials::default(),
            shapes: Vec::new(),
            places: Vec::new(),
            lights: 0,
            recognised: false,
        }
    }
}

impl Builder {
    /// Does what one directive says. One that cannot be is left out with a warning, unless it says what is computed.
    pub fn apply(&mut self, d: Directive, log: &mut Log) -> Result<(), Error> {
        if self.phase == Phase::Done {
            log.warn_once("after WorldEnd", d.at, "what follows WorldEnd is not read");
            return Ok(());
        }
        self.recognised |= DIRECTIVES.contains(&d.name.as_str());
        if SETTINGS.contains(&d.name.as_str()) {
            return self.setting(d, log);
        }
        if let Some(meant) = near(&d.name, &["Integrator", "SurfaceIntegrator", "Sampler"]) {
            // Without it the picture would be computed in another way than its name says.
            let message = format!("unknown directive {}, did you mean {meant}?", shown(&d.name));
            return Err(log.error(d.at, message));
        }
        self.obey(d, log).or_else(|e| log.leave_out(e, "it is left out"))
    }

    /// One of [`SETTINGS`].
    fn setting(&mut self, d: Directive, log: &mut Log) -> Result<(), Error> {
        let at = d.at;
        if self.phase == Phase::World {
            let message = format!("{} belongs before WorldBegin; it is read all the same", d.name);
            log.warn_once(&format!("late {}", d.name), at, message);
        }
        let name = d.name.clone();
        let (kind, params) = named(d, log)?;
        // pbrt-v2 has another word for the same.
        let role = if name == "SurfaceIntegrator" { "Integrator" } else { name.as_str() };
        let before = self.settings_at.insert(role.to_owned(), (at, name.clone()));
        let (strategy, foreign) = (self.settings.estimator.strategy, self.foreign_integrator.is_some());
        self.header_directive(&name, &kind, params, at, log)?;
        if let Some((place, other)) = before {
            let line = log.locate(place).line;
            let after = if other == name {
                format!("once more, after that of line {line}")
            } else {
                format!("after the {other} of line {line}")
            };
            let chosen = self.settings.estimator.strategy;
            let replaced = chosen != strategy && !foreign;
            self.strategy_replaced |= replaced;
            self.film_replaced |= role == "Film";
            let so =
                if replaced { format!(": by {}, not by {}", chosen.name(), strategy.name()) } else { String::new() };
            log.warn(at, format!("{name} {after}; as in pbrt this one counts, as a whole{so}"));
        }
        Ok(())
    }

    /// Any other directive.
    fn obey(&mut self, mut d: Directive, log: &mut Log) -> Result<(), Error> {
        let at = d.at;
        match d.name.as_str() {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform"
            | "CoordinateSystem" | "CoordSysTransform" => {
                let transformed = self.transformation(&mut d, log);
                transformed.or_else(|e| log.leave_out(e, "it is left out, and what follows is drawn without it"))
            }
            "WorldBegin" => {
                nothing(&d, log);
                if self.phase != Phase::Header {
                    return Err(log.error(at, "WorldBegin inside the world, expected one WorldBegin"));
                }
                self.phase = Phase::World;
                self.ctm = Transform::IDENTITY;
                self.coordinate_systems.insert("world".to_owned(), Transform::IDENTITY);
                Ok(())
            }
            "WorldEnd" => {
                nothing(&d, log);
                if self.phase != Phase::World {
                    return Err(log.error(at, "WorldEnd without WorldBegin"));
                }
                self.warn_unclosed(log);
                self.phase = Phase::Done;
                Ok(())
            }
            "AttributeBegin" => {
                nothing(&d, log);
                self.begin(Block::Attribute, at, log)
            }
            "AttributeEnd" => {
                nothing(&d, log);
                self.end(Block::Attribute, at, log)
            }
            "TransformBegin" => {
                nothing(&d, log);
                self.begin(Block::Transform, at, log)
            }
            "TransformEnd" => {
                nothing(&d, log);
                self.end(Block::Transform, at, log)
            }
            "ObjectBegin" => {
                log.warn_once("objects", at, "ObjectBegin, ObjectInstance: instances are not supported and left out");
                self.begin(Block::Object, at, log)?;
                self.in_object = true;
                Ok(())
            }
            "ObjectEnd" => {
                self.in_object = false;
                self.end(Block::Object, at, log)
            }
            "ObjectInstance" => {
                log.warn_once("objects", at, "ObjectBegin, ObjectInstance: instances are not supported and left out");
                Ok(())
            }
            "ReverseOrientation" => {
                nothing(&d, log);
                self.graphics.reverse_orientation = !self.graphics.reverse_orientation;
                Ok(())
            }
            "Material" => {
                let (kind, params) = named(d, log)?;
                self.graphics.material = Some(if matches!(kind.as_str(), "" | "none") {
                    params.forget();
                    Surface::Nothing
                } else {
                    Surface::Made(self.materials.define_unnamed(read_bsdf(&kind, params, at, log)?))
                });
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
                self.graphics.material = Some(Surface::Made(self.materials.find(&name, at, log)?));
                Ok(())
            }
            "AreaLightSource" => {
                let (kind, params) = named(d, log)?;
                self.graphics.area_light = read_area_light(&kind, params, at, log)?;
                Ok(())
            }
            "Shape" => self.shape(d, log),
            unknown => self.unknown(unknown, at, log),
        }
    }

    /// A directive that is not read.
    fn unknown(&self, name: &str, at: Pos, log: &mut Log) -> Result<(), Error> {
        if OF_V4.contains(&name) {
            log.found_v4();
            log.warn_dialect(at, format!("{name} is pbrt-v4's and left out"), format!("{name} left out"));
            return Ok(());
        }
        let key = format!("directive {name}");
        if !log.has_said(&key) {
            let guess = suggestion(name, &DIRECTIVES);
            log.warn_once(&key, at, format!("directive {} is not supported and left out{guess}", shown(name)));
        }
        Ok(())
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
            "Sampler" => {
                self.has_sampler = true;
                header::sampler(kind, params, at, &mut self.settings, log)?;
            }
            "PixelFilter" => header::pixel_filter(kind, params, at, log)?,
            "Camera" => {
                let world_from_camera = self.ctm.inverted();
                let (matrix, max) = (world_from_camera.matrix, MAX_CAMERA);
                let largest = matrix.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                if largest > max || matrix.determinant().abs() < 1.0 / max {
                    let message = "Camera under a transformation that scales or moves it too far";
                    return Err(log.error(at, format!("{message}, expected factors and distances up to {max:e}")));
                }
                self.camera = Some(header::camera(kind, params, at, matrix, log)?);
                self.coordinate_systems.insert("camera".to_owned(), world_from_camera);
            }
            _ => {
                let ours = header::integrator(kind, params, at, &mut self.settings, log)?;
                self.has_integrator = ours;
                self.foreign_integrator = (!ours).then(|| kind.to_owned());
            }
        }
        Ok(())
    }

    fn transformation(&mut self, d: &mut Directive, log: &mut Log) -> Result<(), Error> {
        let ctm = self.ctm;
        let (at, name) = (d.at, d.name.clone());
        let degenerate = |message: &str, log: &Log| log.error(at, format!("{name}: {message}"));
        let new = match name.as_str() {
            "Identity" => {
                nothing(d, log);
                Transform::IDENTITY
            }
            "Translate" => ctm * Transform::translate(DVec3::from_array(numbers(d, log)?)),
            "Scale" => ctm * Transform::scale(DVec3::from_array(numbers(d, log)?)),
            "Rotate" => {
                let [degrees, axis @ ..] = numbers::<4>(d, log)?;
                let turn = Transform::rotate(degrees, DVec3::from_array(axis));
                ctm * turn.ok_or_else(|| degenerate("axis 0 0 0, expected a direction", log))?
            }
            "LookAt" => {
                let v = numbers::<9>(d, log)?;
                let [eye, look, up] = [0, 3, 6].map(|i| DVec3::from_slice(&v[i..i + 3]));
                let view = Transform::look_at(eye, look, up);
                ctm * view.ok_or_else(|| {
                    let expected = "expected eye and target apart, and an up direction not along the line between them";
                    degenerate(expected, log)
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
        self.ctm = new;
        Ok(())
    }

    fn begin(&mut self, block: Block, at: Pos, log: &Log) -> Result<(), Error> {
        if self.open.len() >= MAX_DEPTH {
            return Err(log.error(at, format!("blocks inside each other, expected at most {MAX_DEPTH} deep")));
        }
        self.open.push((block, at));
        self.saved_transforms.push(self.ctm);
        if block != Block::Transform {
            self.saved_graphics.push(self.graphics);
        }
        Ok(())
    }

    /// Restores what the innermost block of this kind (of the kinds that save the graphics state, the innermost one)
    /// saved. Blocks that are crossed are closed as in pbrt-v3.
    fn end(&mut self, block: Block, at: Pos, log: &mut Log) -> Result<(), Error> {
        let name = block.name();
        if let Some((inner, begin)) = self.open.pop()
            && inner != block
            && !log.has_said(CROSSED)
        {
            let (open, line) = (inner.name(), log.locate(begin).line);
            let message = format!("{name}End, expected {open}End for the {open}Begin of line {line}");
            log.warn_once(CROSSED, at, format!("{message}; blocks are closed as in pbrt-v3"));
        }
        if block != Block::Transform {
            let Some(graphics) = self.saved_graphics.pop() else {
                return Err(log.error(at, format!("{name}End without {name}Begin")));
            };
            self.graphics = graphics;
        } else if self.saved_transforms.is_empty() {
            return Err(log.error(at, format!("{name}End without {name}Begin")));
        }
        self.ctm = self.saved_transforms.pop().unwrap_or(self.ctm);
        Ok(())
    }

    fn warn_unclosed(&mut self, log: &mut Log) {
        for (block, at) in std::mem::take(&mut self.open) {
            if !log.has_said(CROSSED) {
                log.warn_once("unclosed", at, format!("{}Begin is never closed", block.name()));
            }
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
        let Graphics { material, area_light, reverse_orientation: reverse } = self.graphics;
        let is_light = area_light.is_some();
        let place = Placement { world_from_object: &self.ctm.matrix, reverse, is_light, folders: &folders };
        let Some(surface) = read_shape(&kind, params, at, &place, log)? else { return Ok(()) };
        if self.in_object {
            return Ok(());
        }
        let material = match (material, area_light) {
            (Some(Surface::Made(made)), _) => self.materials.use_for_shape(Some(made), is_light),
            (None, _) => self.materials.use_for_shape(None, is_light),
            // As in pbrt, it shines nevertheless.
            (Some(Surface::Nothing), Some(_)) => None,
            (Some(Surface::Nothing), None) => {
                log.warn_once("interface", at, "a shape of material \"none\" is a border of media and left out");
                return Ok(());
            }
        };
        let light = area_light.map(|radiance| {
            self.lights += 1;
            Light { name: format!("light{}", self.lights), radiance, on: true }
        });
        let reverse_orientation = surface.reverse_orientation;
        self.shapes.push(Shape { geometry: surface.geometry, reverse_orientation, material, light });
        self.places.push(at);
        Ok(())
    }

    /// The scene, once all directives are read. `end` is where the file ends.
    pub fn finish(mut self, name: String, source: String, log: &mut Log, end: Pos) -> Result<SceneFile, Error> {
        if !self.recognised {
            return Err(log.error(Pos { offset: 0, ..end }, "no pbrt directive found, expected a pbrt-v3 scene file"));
        }
        match self.phase {
            Phase::Header => log.warn(end, "no WorldBegin: the scene is empty"),
            Phase::World => log.warn_dialect(end, "no WorldEnd: the file may be incomplete", "no WorldEnd"),
            Phase::Done => {}
        }
        self.warn_unclosed(log);
        header::defaults(&mut self.settings, self.film_filename.is_some(), self.has_sampler || self.has_integrator);
        let camera = self.camera.unwrap_or_else(|| {
            log.warn(end, "no Camera: seen from the origin along +z with a field of view of 90 degrees, as in pbrt");
            Camera { world_from_camera: DMat4::IDENTITY, fov_deg: 90.0, screen_window: None }
        });
        for (shape, at) in self.shapes.iter_mut().zip(&self.places) {
            enlarge(shape, &camera, *at, log);
        }
        let (materials, index) = self.materials.finish();
        for shape in &mut self.shapes {
            shape.material = shape.material.and_then(|i| index[i]);
        }
        warn_of_twins(&self.shapes, &materials, &self.places, log);
        Ok(SceneFile {
            scene: Scene { name, camera, materials, shapes: self.shapes },
            settings: self.settings,
            film_filename: self.film_filename.unwrap_or_else(|| "pbrt.exr".to_owned()),
            foreign_integrator: self.foreign_integrator,
            contradicts_itself: self.strategy_replaced && !self.film_replaced,
            warnings: log.take_warnings(),
            source,
        })
    }
}
