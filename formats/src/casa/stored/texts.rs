//! Texts of standard storage managers.
//!
//! A cell says in which bucket a text is, where it begins there, and how long it is; the rest of one that has
//! no room in its bucket is in the next. Short ones are in the cell itself.

use super::standard::{Manager, Place};
use super::stream::Stream;

/// Bytes of a cell: three numbers.
const CELL_BYTES: u64 = 12;
/// The longest text that is in its cell.
const MAX_SHORT: u32 = 8;
/// What a bucket of texts begins with: something else, how much of the rest is used, how much of that is no
/// longer, and which bucket is next.
const HEAD_BYTES: u64 = 16;

/// Whether all texts of a column are where its cells say that they are.
pub(super) fn check(manager: &Manager, column: Place) -> Result<(), String> {
    manager.check_cells(column, CELL_BYTES, |cells| {
        let cell = (cells.u32()?, cells.u32()?, cells.u32()?);
        check_text(manager, cell)
    })
}

/// The start of a bucket of texts.
#[derive(Clone, Copy)]
struct Head {
    used: u32,
    next: u32,
}

fn check_text(manager: &Manager, cell: (u32, u32, u32)) -> Result<(), String> {
    let (bucket, offset, length) = cell;
    if length <= MAX_SHORT {
        return Ok(());
    }
    let room = manager.bucket_bytes().saturating_sub(HEAD_BYTES);
    let n_bucket = manager.n_bucket();
    follow(bucket, offset, length, n_bucket, |bucket| {
        let bytes = manager.read(bucket.into(), 0, HEAD_BYTES)?;
        let mut stream = Stream::new(&bytes, true);
        stream.u32()?;
        let used = stream.u32()?;
        if u64::from(used) > room {
            return Err(format!(
                "bucket {bucket} has {used} bytes in use, of {room}"
            ));
        }
        stream.u32()?;
        let next = stream.u32()?;
        Ok(Head { used, next })
    })
}

/// From bucket to bucket until all of a text has been found.
fn follow(
    mut bucket: u32,
    mut offset: u32,
    length: u32,
    n_bucket: u64,
    head: impl Fn(u32) -> Result<Head, String>,
) -> Result<(), String> {
    let mut left = length;
    // No text is in a bucket twice.
    for _ in 0..n_bucket {
        let Head { used, next } = head(bucket)?;
        if offset >= used {
            return Err(format!(
                "{left} bytes of a text are at byte {offset} of bucket {bucket}, which has {used}"
            ));
        }
        let here = used - offset;
        if left <= here {
            return Ok(());
        }
        left -= here;
        (bucket, offset) = (next, 0);
    }
    Err(format!(
        "a text of {length} bytes is not in {n_bucket} buckets"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_goes_on_in_the_next_bucket() {
        let heads = [Head { used: 60, next: 1 }, Head { used: 10, next: 0 }];
        let text = |offset, length| {
            follow(0, offset, length, 2, |bucket| {
                heads
                    .get(bucket as usize)
                    .copied()
                    .ok_or_else(|| "nowhere".into())
            })
        };
        assert!(text(40, 30).is_ok());
        // The next of the second is the first.
        assert!(text(40, 31).unwrap_err().contains("not in 2 buckets"));
        assert!(
            text(60, 9)
                .unwrap_err()
                .contains("byte 60 of bucket 0, which has 60")
        );
    }
}
