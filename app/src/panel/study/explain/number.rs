//! Numbers of any size as they are written here.

/// A number in three digits, however small.
pub fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) { format!("{value:.2e}") } else { digits(value) }
}

fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, 0.012_345, 1.234_5, 123.4, 1e-5].map(short), ["0", "0.0123", "1.23", "123", "1.00e-5"]);
    }
}
