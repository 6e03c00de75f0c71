//! The known name nearest to a misspelt one, by edit distance.

/// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().collect();
    let b: Vec<char> = b.chars().collect();
    let mut before_last = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let substitution = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substitution.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = last;
        last = row;
    }
    last[b.len()]
}

/// The known name nearest to `name`, if it is a likely correction: at most a third of its letters differ, or
/// one contains the other.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    // Longer than any name of the format: the quadratic search is not worth its cost.
    const LONGEST: usize = 64;
    if name.chars().count() > LONGEST {
        return None;
    }
    let lower = name.to_lowercase().replace('-', "_");
    let mut best: Option<(usize, &str)> = None;
    for candidate in known {
        if candidate.chars().count() > LONGEST {
            continue;
        }
        let other = candidate.to_lowercase().replace('-', "_");
        let letters = lower.chars().count().max(other.chars().count());
        let contained = lower.chars().count() >= 3
            && other.chars().count() >= 3
            && (other.contains(&lower) || lower.contains(&other));
        let distance = edit_distance(&lower, &other);
        let near = distance * 3 <= letters || contained;
        if near && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised_and_strangers_are_not() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("ab", "ba"), 1);
        let keys = ["velocity", "position", "material", "youngs_modulus"];
        assert_eq!(nearest("velocty", keys).as_deref(), Some("velocity"));
        assert_eq!(nearest("Psoition", keys).as_deref(), Some("position"));
        assert_eq!(nearest("modulus", keys).as_deref(), Some("youngs_modulus"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(nearest(&"x".repeat(10_000), keys), None);
    }
}
