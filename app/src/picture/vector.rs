//! The toolkit's shapes as SVG: lines stay lines and text stays text. What SVG has no word for becomes a small image.

use std::fmt::Write as _;

use eframe::egui::epaint::{
    BandShape, CircleShape, ClippedShape, ColorMode, EllipseShape, PathShape, PathStroke, RectShape, TextShape,
};
use eframe::egui::{Color32, FontFamily, Galley, Pos2, Rect, Shape, Stroke, StrokeKind};

use crate::picture::png_file;
use crate::picture::raster::Offscreen;

/// The document: one unit is one point.
///
/// # Errors
/// As the encoder of PNG, for what has to be an image.
pub fn svg(drawn: &Offscreen) -> Result<String, png::EncodingError> {
    let [width, height] = drawn.size.map(|n| n as f32 / drawn.scale);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <rect width=\"100%\" height=\"100%\" {}/>\n",
        paint("fill", drawn.ground)
    );
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(width, height));
    let mut clip: Option<Rect> = None;
    let mut clips = 0;
    for shape in &drawn.shapes {
        let wanted = (!shape.clip_rect.contains_rect(whole)).then(|| shape.clip_rect.intersect(whole));
        if wanted.is_some_and(|rect| !rect.is_positive()) {
            continue;
        }
        if wanted != clip {
            out += if clip.is_some() { "</g>\n" } else { "" };
            if let Some(rect) = wanted {
                clips += 1;
                let _ = writeln!(
                    out,
                    "<clipPath id=\"c{clips}\"><rect {}/></clipPath>\n<g clip-path=\"url(#c{clips})\">",
                    corners(rect)
                );
            }
            clip = wanted;
        }
        element(&mut out, drawn, shape)?;
    }
    out += if clip.is_some() { "</g>\n" } else { "" };
    out += "</svg>\n";
    Ok(out)
}

fn element(out: &mut String, drawn: &Offscreen, clipped: &ClippedShape) -> Result<(), png::EncodingError> {
    match &clipped.shape {
        Shape::Noop | Shape::Callback(_) => {}
        Shape::Vec(shapes) => {
            for shape in shapes {
                element(out, drawn, &ClippedShape { shape: shape.clone(), ..clipped.clone() })?;
            }
        }
        Shape::Circle(CircleShape { center, radius, fill, stroke }) => {
            let Pos2 { x, y } = center;
            let _ = writeln!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {}/>", both(*fill, *stroke));
        }
        Shape::Ellipse(EllipseShape { center, radius, fill, stroke, angle }) => {
            let (Pos2 { x, y }, turn) = (center, turned(*angle, *center));
            let _ = writeln!(
                out,
                "<ellipse cx=\"{x}\" cy=\"{y}\" rx=\"{}\" ry=\"{}\" {}{turn}/>",
                radius.x,
                radius.y,
                both(*fill, *stroke)
            );
        }
        Shape::LineSegment { points, stroke } => line(out, points, false, both(Color32::TRANSPARENT, *stroke)),
        Shape::Path(PathShape { points, closed, fill, stroke }) => {
            line(out, points, *closed, both(*fill, solid(stroke, points)));
        }
        Shape::Band(BandShape { points, fill, stroke, angle: 0.0, .. }) => {
            let there = points.iter().map(|point| Pos2::new(point.x, point.y.min));
            let back = points.iter().rev().map(|point| Pos2::new(point.x, point.y.max));
            line(out, &there.chain(back).collect::<Vec<_>>(), true, both(*fill, *stroke));
        }
        Shape::QuadraticBezier(curve) => {
            let points = curve.flatten(None);
            line(out, &points, curve.closed, both(curve.fill, solid(&curve.stroke, &points)));
        }
        Shape::CubicBezier(curve) => {
            let points = curve.flatten(None);
            line(out, &points, curve.closed, both(curve.fill, solid(&curve.stroke, &points)));
        }
        Shape::Rect(rect) if rect.brush.is_none() && rect.blur_width == 0.0 => rectangle(out, rect),
        Shape::Text(shape) => text(out, shape),
        Shape::Rect(_) | Shape::Mesh(_) | Shape::Band(_) => image(out, drawn, clipped)?,
    }
    Ok(())
}

fn line(out: &mut String, points: &[Pos2], closed: bool, paint: String) {
    let name = if closed { "polygon" } else { "polyline" };
    let points: Vec<String> = points.iter().map(|p| format!("{:.2},{:.2}", p.x, p.y)).collect();
    let _ = writeln!(out, "<{name} points=\"{}\" {paint} stroke-linejoin=\"round\"/>", points.join(" "));
}

fn rectangle(out: &mut String, shape: &RectShape) {
    let RectShape { rect, corner_radius, fill, stroke, stroke_kind, angle, .. } = shape;
    // SVG has its strokes on the middle of an edge.
    let by = match stroke_kind {
        StrokeKind::Inside => -0.5,
        StrokeKind::Middle => 0.0,
        StrokeKind::Outside => 0.5,
    } * if stroke.color == Color32::TRANSPARENT { 0.0 } else { stroke.width };
    let radius = (f32::from(corner_radius.nw) + by).max(0.0);
    let turn = turned(*angle, rect.center());
    let _ = writeln!(out, "<rect {} rx=\"{radius}\" {}{turn}/>", corners(rect.expand(by)), both(*fill, *stroke));
}

/// Letters of one format in a row become one element, as long as they are on screen whatever font there is.
fn text(out: &mut String, shape: &TextShape) {
    let galley = &shape.galley;
    let formats = formats(galley);
    let mut next = 0;
    for row in &galley.rows {
        let mut start = 0;
        while let Some(first) = row.glyphs.get(start) {
            // What elides a text is none of its letters.
            let format = |i: usize| formats.get(next + i).or(formats.last()).copied();
            let run = row.glyphs[start..].iter().enumerate().take_while(|(i, _)| format(start + i) == format(start));
            let run: Vec<_> = run.map(|(_, glyph)| glyph).collect();
            let length: f32 = run.iter().map(|glyph| glyph.advance_width).sum();
            let words: String = run.iter().map(|glyph| glyph.chr).collect();
            if let Some(section) = format(start)
                && !words.trim().is_empty()
            {
                let format = &galley.job.sections[section].format;
                let own = if format.color == Color32::PLACEHOLDER { shape.fallback_color } else { format.color };
                let ink = shape.override_text_color.unwrap_or(own).gamma_multiply(shape.opacity_factor);
                let at = shape.pos + row.pos.to_vec2() + first.pos.to_vec2();
                let _ = writeln!(
                    out,
                    "<text x=\"{:.2}\" y=\"{:.2}\" textLength=\"{length:.2}\" lengthAdjust=\"spacingAndGlyphs\" \
                     font-size=\"{}\" {} {}{} xml:space=\"preserve\">{}</text>",
                    at.x,
                    at.y,
                    format.font_id.size,
                    family(&format.font_id.family),
                    paint("fill", ink),
                    turned(shape.angle, shape.pos),
                    escaped(&words)
                );
            }
            start += run.len();
        }
        next += row.glyphs.len() + usize::from(row.ends_with_newline);
    }
}

/// For each letter of the text the index of its section.
fn formats(galley: &Galley) -> Vec<usize> {
    let sections = &galley.job.sections;
    let of = |at: usize| sections.iter().position(|s| s.byte_range.start.0 <= at && at < s.byte_range.end.0);
    galley.job.text.char_indices().map(|(at, _)| of(at).unwrap_or(0)).collect()
}

fn family(family: &FontFamily) -> &'static str {
    match family {
        FontFamily::Monospace => "font-family=\"Hack, 'DejaVu Sans Mono', monospace\"",
        FontFamily::Proportional => "font-family=\"Roboto, Helvetica, Arial, sans-serif\"",
        // The only one with a name is the medium weight of the same.
        FontFamily::Name(_) => "font-family=\"Roboto, Helvetica, Arial, sans-serif\" font-weight=\"500\"",
    }
}

/// What only pixels can show.
fn image(out: &mut String, drawn: &Offscreen, shape: &ClippedShape) -> Result<(), png::EncodingError> {
    let ([left, top, width, height], pixels) = drawn.alone(shape);
    if width == 0 || height == 0 {
        return Ok(());
    }
    let [x, y, w, h] = [left, top, width, height].map(|n| n as f32 / drawn.scale);
    let data = base64(&png_file::encode(width, height, &pixels)?);
    let _ = writeln!(
        out,
        "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" xlink:href=\"data:image/png;base64,{data}\"/>"
    );
    Ok(())
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(group.get(i).copied().unwrap_or(0)));
        for digit in 0..4 {
            let value = (bits >> (18 - 6 * digit)) & 63;
            out.push(if digit <= group.len() { char::from(DIGITS[value as usize]) } else { '=' });
        }
    }
    out
}

fn corners(rect: Rect) -> String {
    let (min, size) = (rect.min, rect.size());
    format!("x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\"", min.x, min.y, size.x, size.y)
}

fn both(fill: Color32, stroke: Stroke) -> String {
    let fill = if fill == Color32::TRANSPARENT { "fill=\"none\"".to_owned() } else { paint("fill", fill) };
    if stroke.width <= 0.0 || stroke.color == Color32::TRANSPARENT {
        return fill;
    }
    format!("{fill} {} stroke-width=\"{}\"", paint("stroke", stroke.color), stroke.width)
}

/// The colour of a stroke that changes along its way, at its beginning.
fn solid(stroke: &PathStroke, points: &[Pos2]) -> Stroke {
    let color = match (&stroke.color, points.first()) {
        (ColorMode::Solid(color), _) => *color,
        (ColorMode::UV(of), Some(first)) => of(Rect::from_points(points), *first),
        (ColorMode::UV(_), None) => Color32::TRANSPARENT,
    };
    Stroke::new(stroke.width, color)
}

fn paint(what: &str, color: Color32) -> String {
    let [r, g, b, a] = color.to_srgba_unmultiplied();
    let opacity = if a == 255 { String::new() } else { format!(" {what}-opacity=\"{:.3}\"", f32::from(a) / 255.0) };
    format!("{what}=\"#{r:02x}{g:02x}{b:02x}\"{opacity}")
}

fn turned(angle: f32, about: Pos2) -> String {
    if angle == 0.0 {
        return String::new();
    }
    format!(" transform=\"rotate({:.3} {} {})\"", angle.to_degrees(), about.x, about.y)
}

fn escaped(text: &str) -> String {
    let of = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        // Nothing else below the blank may stand in a document.
        c if c < ' ' => " ".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(of).collect()
}

#[cfg(test)]
mod tests {
    use eframe::egui::{self, Align2, FontId, pos2};

    use super::*;
    use crate::look::theme::{TypeScale, medium};

    #[test]
    fn lines_stay_lines_and_text_stays_text() {
        let drawn = Offscreen::new([400, 200], 2.0, false, TypeScale::Desk, |ui| {
            let painter = ui.painter_at(Rect::from_min_max(pos2(0.0, 0.0), pos2(100.0, 100.0)));
            painter.line_segment([pos2(1.0, 2.0), pos2(30.0, 40.0)], Stroke::new(1.5, Color32::RED));
            painter.circle_filled(pos2(5.0, 6.0), 3.0, Color32::from_rgba_unmultiplied(0, 0, 255, 128));
            let font = FontId::new(16.0, medium());
            ui.painter().text(pos2(10.0, 10.0), Align2::LEFT_TOP, "p < 1 & more", font, Color32::BLACK);
            ui.painter().add(Shape::gradient_rect(
                Rect::from_min_max(pos2(120.0, 10.0), pos2(180.0, 20.0)),
                egui::Direction::LeftToRight,
                [Color32::BLACK, Color32::WHITE],
            ));
        });
        let text = svg(&drawn).expect("can be encoded");
        for part in [
            "viewBox=\"0 0 200 100\"",
            "<polyline points=\"1.00,2.00 30.00,40.00\" fill=\"none\" stroke=\"#ff0000\" stroke-width=\"1.5\"",
            "<circle cx=\"5\" cy=\"6\" r=\"3\" fill=\"#0000ff\" fill-opacity=\"0.502\"/>",
            ">p &lt; 1 &amp; more</text>",
            "font-weight=\"500\"",
            "<image x=\"119.5\" y=\"9.5\" width=\"61\" height=\"11\" xlink:href=\"data:image/png;base64,iVBORw0KGgo",
        ] {
            assert!(text.contains(part), "{part} is missing in {text}");
        }
        assert_eq!(text.matches("<g ").count(), text.matches("</g>").count());
    }

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        let of = |text: &str| base64(text.as_bytes());
        let found = ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(of);
        assert_eq!(found, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
    }
}
