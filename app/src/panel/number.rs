//! Numbers as people type them, and as they are written.

use std::cell::Cell;

use eframe::egui::{Context, Id};

/// What a person means by a typed number: decimal comma or point, spaces between thousands, a unit behind it, the minus of
/// books. `None` if it is none.
pub fn parse(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    let unit = unit.trim();
    let text = text.strip_suffix(unit).unwrap_or(text);
    let spaces = |c: &char| !c.is_whitespace() && *c != '\u{a0}' && *c != '\u{202f}' && *c != '\'';
    let plain: String = text.chars().filter(spaces).map(|c| if c == '\u{2212}' { '-' } else { c }).collect();
    // With both, the last one is the decimal mark; with one, it is.
    let decimal = plain.rfind([',', '.']);
    let number: String = plain
        .char_indices()
        .filter(|(at, c)| Some(*at) == decimal || !matches!(c, ',' | '.'))
        .map(|(_, c)| if c == ',' { '.' } else { c })
        .collect();
    let marks = plain.matches([',', '.']).count();
    let mixed = plain.contains(',') && plain.contains('.');
    // "1.2.3" is a date or a version.
    if marks > 1 && !mixed {
        return None;
    }
    number.parse().ok().filter(|value: &f64| value.is_finite())
}

/// The same of a field that shows `shown` for `value`: what is left as it stood stays what it was to the last digit.
pub fn parse_field(typed: &str, shown: &str, value: f64, unit: &str) -> Option<f64> {
    if typed.trim() == shown.trim() { Some(value) } else { parse(typed, unit) }
}

/// Notes a text that was no number, to be said by the window.
pub fn refuse(ctx: &Context, text: &str) {
    ctx.data_mut(|data| data.insert_temp(refused_id(), text.to_owned()));
}

/// What was typed in a field for numbers and is none, once.
pub fn take_refused(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(refused_id()))
}

fn refused_id() -> Id {
    Id::unique("refused number")
}

/// What a field takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Any number.
    Real,
    /// Whole numbers; neither comma nor point means anything in them.
    Whole,
}

/// A parser for a field, which notes whether it has refused a text.
pub fn parser<'a>(
    shown: String,
    value: f64,
    unit: &'a str,
    kind: Kind,
    refused: &'a Cell<Option<String>>,
) -> impl Fn(&str) -> Option<f64> + 'a {
    move |typed| {
        let parsed = parse_field(typed, &shown, value, unit).filter(|_| match kind {
            Kind::Real => true,
            Kind::Whole => !typed.contains([',', '.', 'e', 'E']),
        });
        if parsed.is_none() {
            refused.set(Some(typed.trim().to_owned()));
        }
        parsed
    }
}

/// Counts in units a person reads: "82.1 M".
pub fn si(value: f64) -> String {
    const UNITS: [(f64, &str); 4] = [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")];
    match UNITS.iter().find(|(unit, _)| value.abs() >= 0.9995 * unit) {
        Some((unit, name)) => format!("{} {name}", three_digits(value / unit)),
        None => format!("{value:.0}"),
    }
}

/// A duration: "0.41 s", "12.3 s", "2:03 min".
pub fn seconds(seconds: f64) -> String {
    if seconds < 99.95 {
        format!("{} s", three_digits(seconds))
    } else if seconds < 3600.0 {
        format!("{}:{:02} min", (seconds / 60.0) as u64, (seconds % 60.0) as u64)
    } else {
        format!("{}:{:02} h", (seconds / 3600.0) as u64, (seconds / 60.0 % 60.0) as u64)
    }
}

/// Three digits, as many decimals as that leaves.
pub fn three_digits(value: f64) -> String {
    let magnitude = value.abs();
    let decimals = if magnitude < 9.995 {
        2
    } else if magnitude < 99.95 {
        1
    } else {
        0
    };
    format!("{value:.decimals$}")
}

/// Two significant digits of any magnitude: "0.012", "1.3", "0.00045"; smaller than that as a power.
pub fn two_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "\u{2013}".to_owned() };
    }
    let power = value.abs().log10().floor() as i32;
    if power < -5 { format!("{value:.1e}") } else { format!("{value:.*}", (1 - power).max(0) as usize) }
}

/// So many decimals, with the minus of books; never "\u{2212}0.00".
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "\u{2212}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        let written = [(-1e-8, 2), (0.004, 2), (-0.996, 2), (-0.5, 3)].map(|(value, decimals)| signed(value, decimals));
        assert_eq!(written, ["0.00", "0.00", "\u{2212}1.00", "\u{2212}0.500"]);
    }

    #[test]
    fn numbers_are_read_as_people_type_them() {
        for (text, value) in [
            ("1,5", 1.5),
            (" 0.25 ", 0.25),
            ("\u{2212}2,5 EV", -2.5),
            ("1 000", 1000.0),
            ("1.234,5", 1234.5),
            ("1,234.5", 1234.5),
            ("1\u{202f}234", 1234.0),
            ("1e-3", 1e-3),
            (",5", 0.5),
        ] {
            assert_eq!(parse(text, " EV"), Some(value), "{text}");
        }
        for text in ["", "x", "1,2,3", "1.2.3", "inf", "nan", "1;5"] {
            assert_eq!(parse(text, ""), None, "{text}");
        }
    }

    #[test]
    fn an_untouched_field_keeps_every_digit() {
        assert_eq!(parse_field("0.0333", "0.0333", 0.033_333, ""), Some(0.033_333));
        assert_eq!(parse_field("0.0334", "0.0333", 0.033_333, ""), Some(0.0334));
    }

    #[test]
    fn numbers_are_written_as_people_write_them() {
        assert_eq!(si(82_100_000.0), "82.1 M");
        assert_eq!(si(999_900.0), "1.00 M");
        assert_eq!(si(640.0), "640");
        assert_eq!([0.0123, 1.26, 0.000_45, 57.3].map(two_digits), ["0.012", "1.3", "0.00045", "57"]);
        assert_eq!(seconds(0.4126), "0.41 s");
        assert_eq!(seconds(123.4), "2:03 min");
    }
}
