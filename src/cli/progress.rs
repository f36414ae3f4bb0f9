//! The progress bar: silent with --quiet and where standard error is no terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::detect::Observer;

/// A bar for one stage after the other.
pub(crate) struct Bar {
    bar: ProgressBar,
}

impl Bar {
    pub(crate) fn new(quiet: bool) -> Self {
        let target = if quiet {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let style = "{msg:24} [{bar:30}] {pos}/{len}  {elapsed_precise}  {prefix}  left {eta}";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar }
    }

    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Bar {
    fn stage(&mut self, name: &str, n_step: u64) {
        self.bar.reset();
        self.bar.set_length(n_step);
        self.bar.set_message(name.to_owned());
        self.bar.set_prefix("");
    }

    fn advance(&mut self, n_done: u64, n_eval: u64) {
        self.bar.set_position(n_done);
        if n_eval > 0 {
            let rate = n_eval as f64 / self.bar.elapsed().as_secs_f64().max(1e-3);
            self.bar
                .set_prefix(format!("{n_eval} likelihoods, {rate:.0}/s"));
        }
        self.bar.tick();
    }
}
