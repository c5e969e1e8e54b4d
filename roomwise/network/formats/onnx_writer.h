#pragma once

#include "roomwise/base/file.h"
#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// The bytes of an ONNX file that read_onnx_graph() reads back as `graph`, to the bit. Numbers are
// written as 32-bit floats, whole numbers and booleans as 64-bit integers; outputs are declared
// as floats, those of ArgMax as 64-bit integers. (OpenCV wants their shapes stated, if only as
// dynamic sizes.) Attributes of no kind are left out: graphs that were read from a file lack what
// was without use here (graphs in attributes, texts in lists).
//
// Fails where `graph` is not of an opset that lower() knows, lacks inputs or outputs, or holds a
// tensor that is not as large as its shape says.
[[nodiscard]] Expected<Bytes> write_onnx_graph(const OnnxGraph& graph);

}  // namespace roomwise::network
