//! What a wrong name was probably meant to be: names that differ by case or by a letter or two.

use std::path::Path;

/// The candidate that differs from `word` by case or at most two letters: one in a word of less than five, none in one of
/// less than three, which differ from each other by no more.
pub fn near<'c>(word: &str, candidates: &[&'c str]) -> Option<&'c str> {
    let letters = word.chars().count();
    let allowed = match letters {
        0..=2 => 0,
        3..=4 => 1,
        5..=40 => 2,
        _ => return None,
    };
    let lower = word.to_lowercase();
    let distances = candidates.iter().map(|c| (edit_distance(&lower, &c.to_lowercase()), *c));
    distances.filter(|(distance, _)| *distance <= allowed).min_by_key(|(distance, _)| *distance).map(|(_, c)| c)
}

/// As [`near`], and where one of the two is part of the other: "strategy" for "MISstrategy".
pub fn near_or_part<'c>(word: &str, candidates: &[&'c str]) -> Option<&'c str> {
    const SHORTEST: usize = 5;
    let lower = word.to_lowercase();
    let is_part = |candidate: &str| {
        let candidate = candidate.to_lowercase();
        lower.len().min(candidate.len()) >= SHORTEST && (candidate.contains(&lower) || lower.contains(&candidate))
    };
    near(word, candidates).or_else(|| candidates.iter().copied().find(|c| is_part(c)))
}

/// ` (did you mean "x"?)` for the candidate that is [`near`], else nothing.
pub fn suggestion(word: &str, candidates: &[&str]) -> String {
    near(word, candidates).map_or_else(String::new, |c| format!(" (did you mean \"{c}\"?)"))
}

/// Why there is no file at `path`: the folder it was looked for in, and names there that are near.
pub fn no_such_file(path: &Path) -> String {
    /// Most names of a folder that are looked at.
    const MOST: usize = 10_000;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let shown = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let Ok(entries) = std::fs::read_dir(folder) else {
        return format!("there is no folder {}", shown.display());
    };
    let wanted = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let names: Vec<String> =
        entries.take(MOST).flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let mut candidates: Vec<&str> = names.iter().map(String::as_str).collect();
    candidates.sort_unstable();
    let stem = |name: &str| Path::new(name).file_stem().map(|s| s.to_string_lossy().to_lowercase());
    let mut found: Vec<&str> = near(&wanted, &candidates).into_iter().collect();
    found.extend(candidates.iter().filter(|name| stem(name) == stem(&wanted)));
    found.dedup();
    let guess = match found.as_slice() {
        [] => String::new(),
        [first, rest @ ..] => {
            let or: String = rest.iter().take(2).map(|name| format!(" or \"{name}\"")).collect();
            format!(" (did you mean \"{first}\"{or}?)")
        }
    };
    format!("no such file in {}{guess}", shown.display())
}

/// Levenshtein distance, one row at a time.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
