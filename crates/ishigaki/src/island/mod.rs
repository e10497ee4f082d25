//! Islands: who is connected with whom, who rests.

pub mod aggressive_sleep;
#[expect(clippy::module_inception, reason = "the folder is named after its main room")]
pub mod island;
pub mod sleep;
pub(crate) mod stillness;
