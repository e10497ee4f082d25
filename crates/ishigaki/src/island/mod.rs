//! Islands: who is connected with whom, who rests.

pub mod aggressive_sleep;
pub mod island;
pub mod sleep;
