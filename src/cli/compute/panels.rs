//! The panels of a figure, as the command line names them.
//!
//! In: words such as `cloud` or `skeleton:7:4`.
//! Out: a drawn figure.
//! Invariants: a panel without ranks of its own has those of the command; what a figure cannot show is refused before
//! anything is computed.
//! Must not know: where figures go.

use std::num::NonZeroU32;

use hopes::topology::{Frame, Simplified, View, ViewSpec};

use super::Failure;
use crate::cli::args::{Threshold, rank};
use crate::formats::images::photo::Photo;
use crate::formats::layout::Layout;
use crate::formats::picture::{Backdrop, Figure, Panel, figure, places};

/// A figure has at most so many panels.
pub const MOST: usize = 16;

/// A panel that is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelWord {
    kind: Kind,
    /// k and l.
    ranks: Option<[NonZeroU32; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Image,
    Cloud,
    Diagram,
    Skeleton,
    Simplified,
}

/// Parses a panel: a name, and perhaps k and l.
pub fn panel(word: &str) -> Result<PanelWord, String> {
    let mut parts = word.split(':');
    let kind = match parts.next().unwrap_or_default() {
        "image" => Kind::Image,
        "cloud" => Kind::Cloud,
        "diagram" => Kind::Diagram,
        "skeleton" => Kind::Skeleton,
        "simplified" => Kind::Simplified,
        name => {
            return Err(format!("{name:?} is no panel: there are image, cloud, diagram, skeleton, simplified"));
        }
    };
    let ranks = match (parts.next(), parts.next(), parts.next()) {
        (None, ..) => None,
        (Some(k), Some(l), None) => Some([rank(k)?, rank(l)?]),
        _ => return Err(format!("{word:?} has not two ranks: write K and L, as in skeleton:7:4")),
    };
    if ranks.is_some() && matches!(kind, Kind::Image | Kind::Cloud) {
        return Err(format!("{word:?}: the image and the cloud are the same for all k and l"));
    }
    Ok(PanelWord { kind, ranks })
}

/// How the panels without ranks of their own are cut and simplified.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Their view.
    pub spec: ViewSpec,
    /// Below which half-length edges are collapsed in simplified panels, if not below the scale of the view.
    pub threshold: Option<Threshold>,
}

/// Whether a figure of these panels can be drawn; `has_picture` if the points come from a picture.
pub fn check(words: &[PanelWord], cut: Cut, has_picture: bool, name: &str) -> Result<(), Failure> {
    if words.len() > MOST {
        return Err(Failure::usage(format!("--panels: {} panels are too many: {MOST} are the most", words.len())));
    }
    let has = |wanted| words.iter().any(|word| word.kind == wanted);
    if has(Kind::Image) && !has_picture {
        return Err(Failure::usage(format!(
            "--panels image: {name} is no picture, it has points: leave out image, or give a PNG or JPEG"
        )));
    }
    let needs_radius = |word: &PanelWord| word.kind == Kind::Simplified && word.ranks.is_none();
    if cut.spec == ViewSpec::Full
        && !matches!(cut.threshold, Some(Threshold::Below(_)))
        && words.iter().any(needs_radius)
    {
        return Err(Failure::usage("--panels simplified with --full needs a radius: --simplify=RADIUS"));
    }
    Ok(())
}

/// Draws them.
pub fn draw(
    frame: &Frame,
    outliers: &[[f64; 2]],
    layout: Option<&Layout<2>>,
    words: &[PanelWord],
    cut: Cut,
    photo: Option<&Photo>,
    name: Option<&str>,
) -> String {
    let spec = |word: &PanelWord| word.ranks.map_or(cut.spec, |[k, l]| ViewSpec::Derived { k, l });
    let views: Vec<View> = words.iter().map(|word| frame.view(spec(word))).collect();
    let threshold = cut.threshold.unwrap_or(Threshold::AtScale);
    let simplify = |(word, view): (&PanelWord, &View)| {
        (word.kind == Kind::Simplified).then(|| super::simplified(frame, view, threshold))
    };
    let simplified: Vec<Option<(f64, Simplified)>> = words.iter().zip(&views).map(simplify).collect();
    let simplified: Vec<_> = simplified
        .iter()
        .map(|simplified| {
            simplified.as_ref().map(|(threshold, s)| (*threshold, places(&s.positions, layout), &s.edges))
        })
        .collect();
    let panels =
        words.iter().zip(&views).zip(&simplified).map(|((word, view), simplified)| match (word.kind, simplified) {
            (Kind::Image, _) => Panel::Image,
            (Kind::Cloud, _) => Panel::Cloud,
            (Kind::Diagram, _) => Panel::Diagram(view),
            (Kind::Skeleton | Kind::Simplified, None) => Panel::Skeleton(view),
            (Kind::Skeleton | Kind::Simplified, Some((threshold, places, edges))) => {
                Panel::Simplified { view, threshold: *threshold, simplified: (places, edges) }
            }
        });
    let photo = photo.map(|photo| Backdrop { png: photo.small_png(), size: photo.size() });
    figure(&Figure { name, skeleton: &frame.skeleton, outliers, layout, photo, panels: panels.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_have_names_and_ranks() {
        let ranks = |k, l| Some([NonZeroU32::new(k).unwrap(), NonZeroU32::new(l).unwrap()]);
        assert_eq!(panel("cloud"), Ok(PanelWord { kind: Kind::Cloud, ranks: None }));
        assert_eq!(panel("skeleton:7:4"), Ok(PanelWord { kind: Kind::Skeleton, ranks: ranks(7, 4) }));
        for (word, says) in [
            ("", "\"\" is no panel: there are image, cloud"),
            ("Skeleton", "is no panel"),
            ("skeleton:7", "two ranks"),
            ("diagram:7:4:1", "two ranks"),
            ("simplified:0:1", "\"0\" is no rank"),
            ("cloud:1:1", "the same for all k and l"),
        ] {
            let error = panel(word).unwrap_err();
            assert!(error.contains(says), "{word}: {error}");
        }
    }
}
