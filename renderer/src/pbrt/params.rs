//! The parameter list of a directive: `"type name" values` pairs, looked up by name and type.

use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};

use super::directives::SETTINGS;
use super::log::{Log, Pos, shown};
use super::parser::{Directive, Item, Values};
use crate::error::Error;
use crate::near::{near_or_part, suggestion};

struct Param {
    kind: String,
    name: String,
    at: Pos,
    values: Values,
    values_at: Pos,
    used: bool,
}

impl Param {
    /// Where the first value stands: inside the brackets, if there are any.
    fn first_value_at(&self) -> Pos {
        let offset = match &self.values {
            Values::Numbers(_, offsets) => offsets.first().copied(),
            Values::Texts(texts) => texts.first().map(|t| t.1),
            Values::Empty => None,
        };
        Pos { offset: offset.unwrap_or(self.values_at.offset), ..self.values_at }
    }
}

/// What a mesh can do without.
const DISPENSABLE: [&str; 4] = ["N", "S", "st", "uv"];

/// Most parameters of one directive.
const MAX_PARAMS: usize = 256;

/// The parameters of one directive. A lookup of an absent parameter is `None`; one that is there
/// with the wrong type, count or value is an error. What was never looked up is warned about at the end.
pub(super) struct Params {
    /// Whose parameters, for messages: `Film "image"`.
    owner: String,
    list: Vec<Param>,
    asked: Vec<&'static str>,
    /// A wrong parameter is warned about and absent, instead of an error.
    lenient: bool,
}

/// A value and where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct At<T> {
    pub value: T,
    pub at: Pos,
}

impl Params {
    /// Pairs declarations with values. `items` are those after the name(s) of the directive.
    fn new(owner: String, items: Vec<Item>, lenient: bool, log: &mut Log) -> Result<Self, Error> {
        let mut params = Self { owner, list: Vec::new(), asked: Vec::new(), lenient };
        let mut items = items.into_iter();
        while let Some(declaration) = items.next() {
            match params.pair(declaration, &mut items, log) {
                Ok((param, None)) => {
                    // As in pbrt, of two equal parameters the last counts.
                    if params.position(&param.name).is_some() {
                        let (owner, name) = (&params.owner, shown(&param.name));
                        log.warn(param.at, format!("{owner}: parameter {name} is given again; this one counts"));
                        params.list.retain(|p| p.name != param.name);
                    }
                    params.list.push(param);
                }
                Ok((param, Some(flaw))) => {
                    if !lenient && !DISPENSABLE.contains(&param.name.as_str()) {
                        return Err(flaw);
                    }
                    log.leave_out(flaw, &format!("{} is left out", shown(&param.name)))?;
                }
                Err(e) if lenient => log.leave_out(e, "it is left out")?,
                Err(e) => return Err(e),
            }
        }
        Ok(params)
    }

    /// The parameter that is declared, with the value that follows, and what is wrong with a number of it.
    fn pair(
        &self,
        declaration: Item,
        items: &mut impl Iterator<Item = Item>,
        log: &Log,
    ) -> Result<(Param, Option<Error>), Error> {
        let Self { owner, list, .. } = self;
        let at = declaration.at;
        let text = match &declaration.values {
            Values::Texts(texts) if texts.len() == 1 => &texts[0].0,
            _ => {
                let message = format!("{owner}: values without a parameter, expected \"type name\" before them");
                return Err(log.error(at, message));
            }
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        let [kind, name] = words[..] else {
            let message = format!("{owner}: found {}, expected a parameter as \"type name\"", shown(text));
            return Err(log.error(at, message));
        };
        let Some(Item { values, at: values_at, flaw }) = items.next() else {
            return Err(log.error(at, format!("{owner}: parameter {} has no value", shown(text))));
        };
        if list.len() >= MAX_PARAMS {
            return Err(log.error(at, format!("{owner}: expected at most {MAX_PARAMS} parameters")));
        }
        Ok((Param { kind: kind.to_owned(), name: name.to_owned(), at, values, values_at, used: false }, flaw))
    }

    /// What a lookup found; where wrong parameters are no errors, they are absent.
    fn settle<T>(&self, found: Result<Option<T>, Error>, log: &mut Log) -> Result<Option<T>, Error> {
        match found {
            Err(e) if self.lenient => log.leave_out(e, "the default is used").map(|()| None),
            found => found,
        }
    }

    /// Where the parameter is declared, if it is there.
    pub fn position(&self, name: &str) -> Option<Pos> {
        self.list.iter().find(|p| p.name == name).map(|p| p.at)
    }

    /// The type that the parameter is declared with, if it is there.
    pub fn kind(&self, name: &str) -> Option<&str> {
        self.list.iter().find(|p| p.name == name).map(|p| p.kind.as_str())
    }

    /// Marks every parameter as known, when the directive as a whole has been warned about.
    pub fn forget(mut self) {
        self.list.clear();
    }

    /// An error if the name of a parameter that nothing asked for is nearly that of one that was asked for: to render
    /// without it would give another picture than the one that is meant.
    pub fn refuse_near_misses(&self, log: &Log) -> Result<(), Error> {
        for p in self.list.iter().filter(|p| !p.used) {
            if let Some(meant) = near_or_part(&p.name, &self.asked) {
                let message =
                    format!("{}: unknown parameter {}, did you mean \"{meant}\"?", self.owner, shown(&p.name));
                return Err(log.error(p.at, message));
            }
        }
        Ok(())
    }

    /// Warns about each parameter that nothing asked for, once per kind of directive.
    pub fn finish(self, log: &mut Log) {
        for p in self.list.iter().filter(|p| !p.used) {
            let key = format!("unused {} {}", self.owner, p.name);
            if !log.has_said(&key) {
                // Not one that is there already.
                let given = |name: &str| self.list.iter().any(|p| p.name == name);
                let candidates: Vec<&str> = self.asked.iter().copied().filter(|name| !given(name)).collect();
                let guess = suggestion(&p.name, &candidates);
                let message = format!("{}: parameter {} is not used{guess}", self.owner, shown(&p.name));
                log.warn_once(&key, p.at, message);
            }
        }
    }

    fn find(&mut self, name: &'static str, kinds: &[&str], log: &Log) -> Result<Option<&Param>, Error> {
        self.asked.push(name);
        let Some(p) = self.list.iter_mut().find(|p| p.name == name) else { return Ok(None) };
        p.used = true;
        if !kinds.contains(&p.kind.as_str()) {
            let declared = shown(&format!("{} {}", p.kind, p.name));
            return Err(log.error(p.at, format!("{}: found {declared}, expected \"{} {name}\"", self.owner, kinds[0])));
        }
        Ok(Some(p))
    }

    /// As [`Self::find`], but a texture or a spectrum, which exist in pbrt and not here, is warned about and absent.
    fn find_plain(&mut self, name: &'static str, kinds: &[&str], log: &mut Log) -> Result<Option<&Param>, Error> {
        if let Some(p) = self.list.iter_mut().find(|p| p.name == name)
            && matches!(p.kind.as_str(), "texture" | "spectrum" | "blackbody")
        {
            p.used = true;
            let message =
                format!("{}: \"{} {name}\" is not supported, the default value is used instead", self.owner, p.kind);
            log.warn(p.at, message);
            return Ok(None);
        }
        self.find(name, kinds, log)
    }

    fn numbers<'p>(p: &'p Param, owner: &str, log: &Log) -> Result<(&'p [f64], &'p [u32]), Error> {
        match &p.values {
            Values::Numbers(values, offsets) => Ok((values, offsets)),
            Values::Empty => Ok((&[], &[])),
            Values::Texts(texts) => {
                let found = texts.first().map_or("", |t| t.0.as_str());
                let message = format!("{owner}: \"{}\" has value {}, expected a number", p.name, shown(found));
                Err(log.error(p.first_value_at(), message))
            }
        }
    }

    fn count_error(owner: &str, p: &Param, found: usize, expected: usize, log: &Log) -> Error {
        let found = if found == 1 { "1 value".to_owned() } else { format!("{found} values") };
        log.error(p.values_at, format!("{owner}: \"{}\" has {found}, expected {expected}", p.name))
    }

    fn exactly<const N: usize>(p: &Param, owner: &str, log: &Log) -> Result<[f64; N], Error> {
        let (values, _) = Self::numbers(p, owner, log)?;
        values.try_into().map_err(|_| Self::count_error(owner, p, values.len(), N, log))
    }

    /// `"float name"`.
    pub fn float(&mut self, name: &'static str, log: &mut Log) -> Result<Option<At<f64>>, Error> {
        Ok(self.floats::<1>(name, log)?.map(|f| At { value: f.value[0], at: f.at }))
    }

    /// `"float name"` with exactly `N` values.
    pub fn floats<const N: usize>(&mut self, name: &'static str, log: &mut Log) -> Result<Option<At<[f64; N]>>, Error> {
        let found = self.strict_floats(name, log);
        self.settle(found, log)
    }

    fn strict_floats<const N: usize>(
        &mut self,
        name: &'static str,
        log: &mut Log,
    ) -> Result<Option<At<[f64; N]>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find_plain(name, &["float"], log)? else { return Ok(None) };
        Ok(Some(At { value: Self::exactly::<N>(p, &owner, log)?, at: p.first_value_at() }))
    }

    /// `"integer name"` in a range.
    pub fn integer(
        &mut self,
        name: &'static str,
        range: RangeInclusive<u32>,
        log: &Log,
    ) -> Result<Option<At<u32>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find(name, &["integer"], log)? else { return Ok(None) };
        let [v] = Self::exactly::<1>(p, &owner, log)?;
        let (least, most) = range.into_inner();
        if v.fract() != 0.0 || v < f64::from(least) || v > f64::from(most) {
            let message = format!("{owner}: \"{name}\" is {v}, expected a whole number from {least} to {most}");
            return Err(log.error(p.first_value_at(), message));
        }
        Ok(Some(At { value: v as u32, at: p.first_value_at() }))
    }

    /// `"integer name"`: a list of indices below `limit`, three each.
    pub fn triangles(&mut self, name: &'static str, limit: usize, log: &Log) -> Result<Option<Vec<[u32; 3]>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find(name, &["integer"], log)? else { return Ok(None) };
        let (values, offsets) = Self::numbers(p, &owner, log)?;
        if !values.len().is_multiple_of(3) {
            let message = format!("{owner}: {} values of \"{name}\", expected three for each triangle", values.len());
            return Err(log.error(p.values_at, message));
        }
        for (&v, &offset) in values.iter().zip(offsets) {
            if v.fract() != 0.0 || v < 0.0 || v >= limit as f64 {
                let at = Pos { offset, ..p.values_at };
                let message = format!("{owner}: index {v}, expected one of the {limit} vertices, counted from 0");
                return Err(log.error(at, message));
            }
        }
        Ok(Some(values.chunks_exact(3).map(|c| [c[0] as u32, c[1] as u32, c[2] as u32]).collect()))
    }

    /// `"point name"`: a list of points.
    pub fn points(&mut self, name: &'static str, log: &Log) -> Result<Option<Vec<DVec3>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find(name, &["point", "point3"], log)? else { return Ok(None) };
        let (values, _) = Self::numbers(p, &owner, log)?;
        if !values.len().is_multiple_of(3) {
            let message = format!("{owner}: {} values of \"{name}\", expected three for each point", values.len());
            return Err(log.error(p.values_at, message));
        }
        Ok(Some(values.chunks_exact(3).map(DVec3::from_slice).collect()))
    }

    /// `"normal name"`: one for each of `count` vertices; absent, with a warning, if they are of another number.
    pub fn normals(&mut self, name: &'static str, count: usize, log: &mut Log) -> Result<Option<Vec<DVec3>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find(name, &["normal", "normal3"], log)? else { return Ok(None) };
        let (values, _) = Self::numbers(p, &owner, log)?;
        if values.len() != 3 * count {
            let found = values.len();
            let message = format!("{owner}: {found} values of \"{name}\" for {count} vertices, expected three each");
            let at = p.values_at;
            log.warn(at, format!("{message}; the order of the vertices decides which side is in front"));
            return Ok(None);
        }
        Ok(Some(values.chunks_exact(3).map(DVec3::from_slice).collect()))
    }

    /// `"string name"`.
    pub fn text(&mut self, name: &'static str, log: &Log) -> Result<Option<At<String>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find(name, &["string"], log)? else { return Ok(None) };
        match &p.values {
            Values::Texts(texts) if texts.len() == 1 => {
                Ok(Some(At { value: texts[0].0.clone(), at: p.first_value_at() }))
            }
            Values::Texts(texts) => Err(Self::count_error(&owner, p, texts.len(), 1, log)),
            Values::Empty => Err(Self::count_error(&owner, p, 0, 1, log)),
            Values::Numbers(values, _) => {
                let message = format!("{owner}: \"{name}\" has value {}, expected a text in quotes", values[0]);
                Err(log.error(p.first_value_at(), message))
            }
        }
    }

    /// `"string name"` with one of the values that `from_name` knows; `expected` lists them.
    pub fn choice<T>(
        &mut self,
        name: &'static str,
        from_name: fn(&str) -> Option<T>,
        expected: &[&str],
        log: &Log,
    ) -> Result<Option<At<T>>, Error> {
        let owner = self.owner.clone();
        let Some(At { value: text, at }) = self.text(name, log)? else { return Ok(None) };
        match from_name(text.trim()) {
            Some(value) => Ok(Some(At { value, at })),
            None => {
                let list = expected.join(", ");
                let message = format!("{owner}: \"{name}\" is {}, expected one of {list}", shown(&text));
                Err(log.error(at, message))
            }
        }
    }

    /// `"bool name"`.
    pub fn boolean(&mut self, name: &'static str, log: &mut Log) -> Result<Option<bool>, Error> {
        let found = self.strict_boolean(name, log);
        self.settle(found, log)
    }

    fn strict_boolean(&mut self, name: &'static str, log: &Log) -> Result<Option<bool>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find(name, &["bool"], log)? else { return Ok(None) };
        let found = match &p.values {
            Values::Texts(texts) if texts.len() == 1 => match texts[0].0.trim() {
                "true" => return Ok(Some(true)),
                "false" => return Ok(Some(false)),
                other => shown(other),
            },
            Values::Texts(texts) => return Err(Self::count_error(&owner, p, texts.len(), 1, log)),
            Values::Empty => return Err(Self::count_error(&owner, p, 0, 1, log)),
            Values::Numbers(values, _) => values[0].to_string(),
        };
        Err(log.error(p.first_value_at(), format!("{owner}: \"{name}\" is {found}, expected \"true\" or \"false\"")))
    }

    /// `"rgb name"` or one of its other spellings, not negative.
    pub fn rgb(&mut self, name: &'static str, log: &mut Log) -> Result<Option<At<Vec3>>, Error> {
        let found = self.strict_rgb(name, log);
        self.settle(found, log)
    }

    fn strict_rgb(&mut self, name: &'static str, log: &mut Log) -> Result<Option<At<Vec3>>, Error> {
        let owner = self.owner.clone();
        let Some(p) = self.find_plain(name, &["rgb", "color", "xyz"], log)? else { return Ok(None) };
        let mut value = DVec3::from_array(Self::exactly::<3>(p, &owner, log)?);
        if p.kind == "xyz" {
            // Rounding, and colours outside the gamut.
            value = rgb_from_xyz(value).max(DVec3::ZERO);
        }
        let at = p.first_value_at();
        let rgb = value.as_vec3();
        if rgb.min_element() < 0.0 {
            let message = format!("{owner}: \"{name}\" is {} {} {}, expected no negative value", rgb.x, rgb.y, rgb.z);
            return Err(log.error(at, message));
        }
        if !rgb.is_finite() {
            return Err(log.error(at, format!("{owner}: \"{name}\" is too large")));
        }
        Ok(Some(At { value: rgb, at }))
    }

    /// [`Self::rgb`] for a reflectance: what lies above 1 would create energy and is cut with a warning.
    pub fn reflectance(&mut self, name: &'static str, default: Vec3, log: &mut Log) -> Result<Vec3, Error> {
        let Some(At { value, at }) = self.rgb(name, log)? else { return Ok(default) };
        if value.max_element() > 1.0 {
            let message = format!("{}: \"{name}\" is {} {} {}, cut to 1", self.owner, value.x, value.y, value.z);
            log.warn(at, message);
        }
        Ok(value.min(Vec3::ONE))
    }
}

/// CIE XYZ to linear Rec. 709 (the matrix of pbrt-v3's `XYZToRGB`).
fn rgb_from_xyz(xyz: DVec3) -> DVec3 {
    DVec3::new(
        DVec3::new(3.240479, -1.537150, -0.498535).dot(xyz),
        DVec3::new(-0.969256, 1.875991, 0.041556).dot(xyz),
        DVec3::new(0.055648, -0.204043, 1.057311).dot(xyz),
    )
}

/// Splits a directive such as `Film "image" ...` into its type and parameters. Wrong parameters are errors in
/// [`SETTINGS`], and in a shape, which is nothing without them.
pub(super) fn named(directive: Directive, log: &mut Log) -> Result<(String, Params), Error> {
    let Directive { name, at, items, .. } = directive;
    let mut items = items.into_iter();
    let kind = match items.next().map(|i| i.values) {
        Some(Values::Texts(mut texts)) if texts.len() == 1 => texts.swap_remove(0).0,
        _ => return Err(log.error(at, format!("{name} without a type or name, expected a text in quotes after it"))),
    };
    let owner = format!("{name} {}", shown(&kind));
    let lenient = name != "Shape" && !SETTINGS.contains(&name.as_str());
    let params = Params::new(owner, items.collect(), lenient, log)?;
    Ok((kind, params))
}

/// The one name of a directive such as `NamedMaterial "plate1"`.
pub(super) fn single_name(directive: &Directive, log: &Log) -> Result<String, Error> {
    match directive.items.as_slice() {
        [Item { values: Values::Texts(texts), .. }] if texts.len() == 1 => Ok(texts[0].0.clone()),
        _ => Err(log.error(directive.at, format!("expected {} and one name in quotes", directive.name))),
    }
}

/// The `N` numbers of a directive such as `Translate`.
pub(super) fn numbers<const N: usize>(directive: &mut Directive, log: &Log) -> Result<[f64; N], Error> {
    let mut all = Vec::with_capacity(N);
    for item in &mut directive.items {
        if let Some(flaw) = item.flaw.take() {
            return Err(flaw);
        }
        match &item.values {
            Values::Numbers(values, _) => all.extend_from_slice(values),
            Values::Empty => {}
            Values::Texts(texts) => {
                let found = texts.first().map_or("", |t| t.0.as_str());
                let message = format!("{}: found {}, expected {N} numbers", directive.name, shown(found));
                return Err(log.error(item.at, message));
            }
        }
    }
    let found = all.len();
    all.try_into()
        .map_err(|_| log.error(directive.at, format!("{} with {found} numbers, expected {N}", directive.name)))
}

/// Nothing may follow a directive such as `AttributeBegin`.
pub(super) fn nothing(directive: &Directive, log: &mut Log) {
    if let Some(item) = directive.items.first() {
        log.warn(item.at, format!("found values after {}, expected none; they are left out", directive.name));
    }
}
