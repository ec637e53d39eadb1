//! Fiducial tag families as data: code words and the layout of a tag's modules.
