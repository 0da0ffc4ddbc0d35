//! The word for the filter of outliers, `K[:R]`, and its options.
//!
//! In: words of the command line.
//! Out: a [`Declutter`], or what it may be.
//! Must not know: which command filters, how outliers are told apart.

use clap::Args;
use hopes::topology::Declutter;

use super::values::number;

/// Whether outliers are left out, and which.
#[derive(Clone, Copy, Debug, Args)]
pub struct DeclutterArgs {
    /// Leave out outliers: points without K others within R [default: K is 3, and R is found from the cloud].
    ///
    /// A point stays if its K-th nearest other position is within R, and if not 2K+2 points within 1.5 times that
    /// distance have one that is four times smaller. Duplicates count once. Unless R is given, it is the largest radius
    /// at which one lone clutter point is expected to have K others, by a density of clutter that is estimated from
    /// lone points; at least twice the median distance. Where no point is alone, all stay.
    ///
    /// The points that stay have the skeleton; the others are counted as filtered, and drawn hollow. Rho is the largest
    /// distance of a point that stays. If no outlier has K outliers within rho and no true point was left out, births
    /// and deaths are right within rho, and dots of a persistence above 2 rho are real. That is certified with R only,
    /// since without it one clutter point more is expected to stay.
    ///
    /// It cannot tell clutter from the thin parts of walls whose density varies by 10:1, nor clumps of more than K
    /// outliers from walls. Clouds whose density falls off smoothly lose some of their tail.
    #[arg(
        long,
        value_name = "K[:R]",
        value_parser = declutter,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "3",
    )]
    declutter: Option<Declutter>,
}

impl DeclutterArgs {
    /// The filter that is asked for.
    pub fn rule(self) -> Option<Declutter> {
        self.declutter
    }
}

/// A number of neighbours, and perhaps a radius.
pub fn declutter(word: &str) -> Result<Declutter, String> {
    let (neighbours, radius) = word.split_once(':').map_or((word, None), |(k, r)| (k, Some(r)));
    let neighbours = neighbours.parse().map_err(|_| format!("{word:?}: write K or K:R, such as 3 or 3:0.25"))?;
    let rule = Declutter::new(neighbours).map_err(|error| error.to_string())?;
    match radius {
        Some(radius) => rule.with_radius(number(radius)?).map_err(|error| error.to_string()),
        None => Ok(rule),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_is_a_number_of_neighbours_and_perhaps_a_radius() {
        assert_eq!(declutter("3"), Ok(Declutter::default()));
        assert_eq!(declutter("5:0.25"), Declutter::new(5).unwrap().with_radius(0.25).map_err(|_| String::new()));
        for (word, says) in [
            ("", "write K or K:R, such as 3 or 3:0.25"),
            ("three", "write K or K:R"),
            ("-1", "write K or K:R"),
            ("0", "0 neighbours cannot be asked for: K is from 1 to 64"),
            ("65", "K is from 1 to 64"),
            ("3:", "\"\" is not a finite number"),
            ("3:0", "a radius of 0 leaves no neighbour"),
            ("3:-1", "R must be above 0"),
            ("3:inf", "\"inf\" is not a finite number"),
            ("3:1:2", "\"1:2\" is not a finite number"),
        ] {
            let error = declutter(word).unwrap_err();
            assert!(error.contains(says), "{word}: {error}");
        }
    }
}
