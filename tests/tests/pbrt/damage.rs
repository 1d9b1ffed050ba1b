//! Damaged files: whatever they hold, nothing panics.

use mislab_kernel::world::BuiltScene;
use mislab_renderer::pbrt;

use crate::files::{PLY_ASCII, ply_binary, write};
use crate::tutorial::HEADER_MIS_ALL;
use crate::world;

/// A small generator of pseudo-random numbers (SplitMix64), so that the damage is always the same.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// Changes, inserts, deletes or duplicates a few bytes.
fn damage(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    const LIKELY: &[u8] = b"\"[]#-+.e0129 \n\\'\xe2\x80\x9c\xc2\xa0AWS";
    let mut out = bytes.to_vec();
    for _ in 0..1 + random.below(6) {
        let at = random.below(out.len());
        match random.below(5) {
            0 => out[at] = random.below(256) as u8,
            1 => out[at] = LIKELY[random.below(LIKELY.len())],
            2 => out.insert(at, LIKELY[random.below(LIKELY.len())]),
            3 => {
                let end = (at + 1 + random.below(40)).min(out.len() - 1);
                out.drain(at.min(end)..end);
            }
            _ => {
                let end = (at + random.below(80)).min(out.len());
                let piece = out[at..end].to_vec();
                let to = random.below(out.len());
                out.splice(to..to, piece);
            }
        }
    }
    out
}

#[test]
fn damaged_scenes_never_panic() {
    let mut random = Random(1);
    let mut read = 0;
    for scene in [pbrt::DEFAULT_SCENE, pbrt::PLASTIC_SCENE, HEADER_MIS_ALL] {
        for _ in 0..2500 {
            let bytes = damage(scene.as_bytes(), &mut random);
            match pbrt::parse(&String::from_utf8_lossy(&bytes), "damaged.pbrt", None) {
                Ok(file) => {
                    read += 1;
                    if let Err(e) = BuiltScene::new(&file.scene, &file.settings) {
                        panic!("what is read can be rendered: {e}\n{}", String::from_utf8_lossy(&bytes));
                    }
                    assert!(
                        file.scene.shapes.iter().all(|s| s.material.is_none_or(|m| m < file.scene.materials.len()))
                    );
                }
                Err(e) => assert!(!e.to_string().contains('\n'), "one line: {e}"),
            }
        }
    }
    assert!(read > 500, "some damage is harmless, {read} were read");
}

#[test]
fn damaged_ply_files_never_panic() {
    let dir = tempfile::tempdir().expect("a folder");
    let text = world("Shape \"plymesh\" \"string filename\" \"x.ply\"");
    let mut random = Random(2);
    for original in [PLY_ASCII.as_bytes().to_vec(), ply_binary(false), ply_binary(true)] {
        for _ in 0..500 {
            write(dir.path(), "x.ply", damage(&original, &mut random));
            // Either is fine; only a panic or an endless loop is not.
            let _ = pbrt::parse(&text, "t.pbrt", Some(dir.path()));
        }
    }
}
