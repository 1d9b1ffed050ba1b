//! The order of boxes along a curve that fills space: neighbours in that order are near each other.

use glam::DVec3;
use obvhs::aabb::Aabb;

use crate::stop::{Stop, Stopped};

/// Digits of a coordinate.
const BITS: u32 = 21;

/// Numbers of the boxes in the order of their centres along a Morton curve; equal ones in the order of their numbers.
pub(super) fn along_curve(boxes: &[Aabb], stop: Stop<'_>) -> Result<Vec<u32>, Stopped> {
    // In double precision, in which no sum or difference of coordinates overflows.
    let center = |b: &Aabb| (b.min.as_dvec3() + b.max.as_dvec3()) * 0.5;
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (i, b) in boxes.iter().enumerate() {
        stop.check_in_turn(i)?;
        (min, max) = (min.min(center(b)), max.max(center(b)));
    }
    let cells = f64::from((1u32 << BITS) - 1);
    let scale = (max - min).to_array().map(|extent| if extent > 0.0 { cells / extent } else { 0.0 });
    let mut keys = Vec::with_capacity(boxes.len());
    for (i, b) in boxes.iter().enumerate() {
        stop.check_in_turn(i)?;
        let [x, y, z] = ((center(b) - min) * DVec3::from(scale)).to_array().map(|v| spread(v as u64));
        keys.push((x | y << 1 | z << 2, i as u32));
    }
    sort(&mut keys, stop)?;
    Ok(keys.into_iter().map(|(_, number)| number).collect())
}

/// Puts two zeros before each of the lowest 21 digits.
fn spread(v: u64) -> u64 {
    let v = (v | v << 32) & 0x001f_0000_0000_ffff;
    let v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    let v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    let v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

/// Sorts by the first number, digit by digit from the last one; what is equal stays in its order. Asks all along, as the
/// library's sort cannot.
fn sort(keys: &mut Vec<(u64, u32)>, stop: Stop<'_>) -> Result<(), Stopped> {
    const DIGIT: u32 = 11;
    let mut sorted = vec![(0, 0); keys.len()];
    for shift in (0..3 * BITS).step_by(DIGIT as usize) {
        let digit = |key: u64| (key >> shift) as usize & ((1 << DIGIT) - 1);
        let mut places = [0; 1 << DIGIT];
        for (i, &(key, _)) in keys.iter().enumerate() {
            stop.check_in_turn(i)?;
            places[digit(key)] += 1;
        }
        let mut before = 0;
        for place in &mut places {
            before += std::mem::replace(place, before);
        }
        for (i, &entry) in keys.iter().enumerate() {
            stop.check_in_turn(i)?;
            let place = &mut places[digit(entry.0)];
            sorted[*place] = entry;
            *place += 1;
        }
        std::mem::swap(keys, &mut sorted);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    #[test]
    fn digits_are_spread_and_keys_sorted_as_by_the_library() {
        assert_eq!(spread(0b1011), 0b001_000_001_001);
        assert_eq!(spread((1 << 21) - 1).count_ones(), 21);
        assert_eq!(spread(1 << 20), 1 << 60);
        let mut keys: Vec<(u64, u32)> =
            (0..5000u64).map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 1 >> (i % 50), i as u32)).collect();
        let mut expected = keys.clone();
        expected.sort_by_key(|&(key, _)| key);
        sort(&mut keys, Stop::NEVER).expect("nobody stops it");
        assert_eq!(keys, expected);
    }

    #[test]
    fn equal_boxes_keep_their_order_and_others_follow_the_curve() {
        let at = |x: f32, y: f32| Aabb::new(Vec3A::new(x, y, 5.0), Vec3A::new(x, y, 5.0));
        let order = |boxes: &[Aabb]| along_curve(boxes, Stop::NEVER).expect("nobody stops it");
        assert_eq!(order(&[at(1.0, 2.0); 4]), [0, 1, 2, 3]);
        assert_eq!(order(&[at(1.0, 1.0), at(0.0, 1.0), at(1.0, 0.0), at(0.0, 0.0)]), [3, 2, 1, 0]);
        assert_eq!(order(&[at(3e38, 0.0), at(-3e38, 0.0)]), [1, 0], "no overflow");
        assert!(order(&[]).is_empty());
    }
}
