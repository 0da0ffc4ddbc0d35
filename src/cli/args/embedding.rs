//! The word for delay vectors, `D:LAG`.
//!
//! In: a word of the command line.
//! Out: an [`Embedding`], or what it may be.
//! Must not know: which command embeds a series.

use crate::formats::input::space::Embedding;

/// Vectors of D samples, each LAG samples after the one before.
pub fn embedding(word: &str) -> Result<Embedding, String> {
    let (dimension, lag) = word.split_once(':').ok_or_else(|| usual(word))?;
    let number = |word: &str| word.parse::<usize>().map_err(|_| usual(word));
    Embedding::new(number(dimension)?, number(lag)?).map_err(|error| error.to_string())
}

fn usual(word: &str) -> String {
    format!(
        "{word:?}: write D:LAG, two whole numbers such as 3:8, for vectors of 3 samples, each 8 after the one before"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_embedding_is_a_dimension_and_a_lag() {
        assert_eq!(embedding("3:8"), Ok(Embedding::new(3, 8).unwrap()));
        for word in ["", "3", "3:", ":8", "3:8:1", "3,8", "-3:8", "3:1.5", "three:8", "99999999999999999999:1"] {
            let error = embedding(word).unwrap_err();
            assert!(
                error.ends_with(
                    "write D:LAG, two whole numbers such as 3:8, for vectors of 3 samples, each 8 after the one before"
                ),
                "{error}"
            );
        }
        assert_eq!(embedding("1:8"), Err("1 is no dimension: a vector has from 2 to 4096 samples".to_owned()));
        assert_eq!(embedding("5000:8").unwrap_err(), "5000 is no dimension: a vector has from 2 to 4096 samples");
        assert_eq!(embedding("2:0"), Err("0 is no lag: it is a number of samples, from 1".to_owned()));
        assert_eq!(
            embedding("4096:257").unwrap_err(),
            "4096 samples at a distance of 257 span more than 1048576 samples: take fewer, or a smaller lag"
        );
    }
}
