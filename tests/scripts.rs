//! Random streams against recomputation from scratch, after every step: same skeleton, bit for bit, and ids that keep their promise.

mod common;

use common::clouds::{Ground, cases};
use common::plot::{scripts, scripts_on};
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

    /// Off the line and back, and ever fewer points on it.
    #[test]
    fn lines_are_left_and_found_again(script in proptest::sample::select(&Ground::LINES[..]).prop_flat_map(scripts_on)) {
        run(&script);
    }
}
