//! LZF, undone: literal bytes, and repeats of what came before.
//!
//! Weights and flags are mostly one value over and over, which becomes a repeat of what stands a few bytes before;
//! liblzf copies that byte by byte, and took up to half of the time of reading a file.
//!
//! # Source
//! The format of Marc Lehmann's liblzf 3.6, `lzf_d.c`: a byte below 32 is followed by that many literals and one more;
//! of any other, the upper three bits are a length less 2 (7: the next byte is added), the lower five with the byte
//! after it the distance back, less 1.

/// Literals of one run at most.
const MAX_LITERALS: usize = 32;
/// A length as long as the three bits can say has another byte.
const LONG: usize = 7;

/// What was made of at most `longest` bytes; none if these are no LZF, or of more.
pub(super) fn decompress(bytes: &[u8], longest: usize) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(longest);
    let mut rest = bytes;
    while let Some((&control, after)) = rest.split_first() {
        let control = usize::from(control);
        if control < MAX_LITERALS {
            let (literals, after) = after.split_at_checked(control + 1)?;
            has_room(&out, literals.len(), longest)?;
            out.extend_from_slice(literals);
            rest = after;
            continue;
        }
        rest = after;
        let mut n = control >> 5;
        if n == LONG {
            n += next(&mut rest)?;
        }
        let back = ((control & 31) << 8 | next(&mut rest)?) + 1;
        has_room(&out, n + 2, longest)?;
        repeat(&mut out, back, n + 2)?;
    }
    Some(out)
}

fn next(rest: &mut &[u8]) -> Option<usize> {
    let (&byte, after) = rest.split_first()?;
    *rest = after;
    Some(usize::from(byte))
}

fn has_room(out: &[u8], n: usize, longest: usize) -> Option<()> {
    (out.len() + n <= longest).then_some(())
}

/// Appends `n` bytes that repeat what begins `back` bytes before the end.
fn repeat(out: &mut Vec<u8>, back: usize, n: usize) -> Option<()> {
    let start = out.len().checked_sub(back)?;
    let end = out.len() + n;
    while out.len() < end {
        // What has been repeated already is as good, so that each copy is twice as long.
        let some = (end - out.len()).min(out.len() - start);
        out.extend_from_within(start..start + some);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_repeats_of_any_period() {
        // "abc", seven bytes from three back, then 7 + 250 + 2 bytes from one back.
        let packed = [2, b'a', b'b', b'c', 5 << 5, 2, 7 << 5, 250, 0];
        let mut wanted = b"abcabcabca".to_vec();
        wanted.extend([b'a'; 259]);
        assert_eq!(decompress(&packed, 300).unwrap(), wanted);
        assert_eq!(decompress(&packed, 268), None, "more than there may be");
        assert_eq!(decompress(&[], 4).unwrap(), b"");
    }

    #[test]
    fn what_is_cut_off_or_reaches_before_the_beginning_is_none() {
        for packed in [
            &[2, b'a', b'b'][..],
            &[0, b'a', 7 << 5],
            &[0, b'a', 7 << 5, 3],
            &[0, b'a', 1 << 5],
            &[0, b'a', 1 << 5, 1],
        ] {
            assert_eq!(decompress(packed, 100), None, "{packed:?}");
        }
    }
}
