//! Headers of this format, and what they mean.
