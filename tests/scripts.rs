//! Random streams against recomputation from scratch after every step: the same skeleton, bit for bit, and stable ids.

mod common;

use common::clouds::{Placement, cases};
use common::random_script::{scripts, scripts_on};
use common::script::run;
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn any_stream_equals_recomputation(script in scripts()) {
        run(&script);
    }
}

proptest! {
    #![proptest_config(cases(300))]

    /// A cloud leaves the line and returns to it, with ever fewer points on it.
    #[test]
    fn clouds_leave_a_line_and_return_to_it(script in proptest::sample::select(&Placement::LINES[..]).prop_flat_map(scripts_on)) {
        run(&script);
    }
}
