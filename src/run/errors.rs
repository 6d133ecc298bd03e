//! Estimated errors of a run, as its summary tells them.

use std::fmt::Write;

use rom_runtime::ErrorEstimate;
use serde::Serialize;

use crate::text::significant;

/// What a reduced model estimates its own errors at, and whether it stayed in the range it holds for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// The largest of the three.
    pub error_indicator: f64,
    /// Relative errors at the end, as a validation measures them: largest error over largest length.
    pub predicted: Predicted,
    /// Largest amplitude over the one at which the terms left out reach a tenth of those kept.
    pub amplitude: f64,
    /// Largest angular rate over the one at which the centrifugal terms left out reach a tenth of the stiffness.
    pub rate: f64,
    /// When the range was left first (an error or terms left out above a tenth), s; none if it was not.
    pub out_of_range_at: Option<f64>,
    /// Whether loads per length acted whose effect on modes that are not in the model is not in the estimate: those that the model was not
    /// built with.
    pub unseen_loads: bool,
}

/// Estimated relative errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Predicted {
    /// Of the velocity of A.
    #[serde(rename = "v_G")]
    pub v_g: f64,
    /// Of the angular velocity of A.
    #[serde(rename = "w_G")]
    pub w_g: f64,
    /// Of the displacements of the named points.
    #[serde(rename = "dR_A")]
    pub dr_a: f64,
}

impl ErrorSummary {
    /// Takes in the estimate at `t`.
    pub fn see(&mut self, t: f64, estimate: &ErrorEstimate) {
        self.predicted = Predicted { v_g: estimate.v_g, w_g: estimate.w_g, dr_a: estimate.dr_a };
        self.error_indicator = estimate.indicator();
        self.unseen_loads |= estimate.unseen_loads;
        self.amplitude = self.amplitude.max(estimate.amplitude);
        self.rate = self.rate.max(estimate.rate);
        if self.out_of_range_at.is_none() && estimate.out_of_range() {
            self.out_of_range_at = Some(t);
        }
    }

    /// One line for the terminal and the report.
    pub fn to_text(&self) -> String {
        let percent = |error: f64| significant(100.0 * error, 2);
        let Predicted { v_g, w_g, dr_a } = self.predicted;
        let unseen = if self.unseen_loads {
            " (without what loads per length that the model was not built with do to the modes left out: compare with more modes)"
        } else {
            ""
        };
        format!(
            "estimated errors of the model: v_G {} %, w_G {} %, dR_A {} %{unseen}",
            percent(v_g),
            percent(w_g),
            percent(dr_a)
        )
    }

    /// What to think of it, where the range was left.
    pub fn warning(&self) -> Option<String> {
        let at = self.out_of_range_at?;
        let mut why = Vec::new();
        if self.error_indicator > 0.1 {
            why.push(format!(
                "the estimated error reaches {} %",
                significant(100.0 * self.error_indicator, 2)
            ));
        }
        for (what, used) in [("amplitudes", self.amplitude), ("angular rates", self.rate)] {
            if used > 1.0 {
                why.push(format!("{what} reach {} times their limit", significant(used, 2)));
            }
        }
        // The estimate is relative to the motion so far, and may fall again.
        if why.is_empty() {
            why.push("the estimated error exceeded 10 %, and no longer does at the end".into());
        }
        let mut text = format!("from t = {} s the model is out of its range: ", significant(at, 4));
        let _ = write!(
            text,
            "{}. `romgen validate` measures the error; see `romgen info` for the limits.",
            why.join(", ")
        );
        Some(text)
    }
}
