// New vertices, from chunks of 64 of a body, to positions in the grid frame. Resets the lists, too.
layout(std430, binding = 1) buffer Vertices { vec4 outVertices[]; };
layout(std430, binding = 3) readonly buffer Source { uint source[]; }; // the stream, or another buffer with floats
// xyz: bits of a position about the body's centre; w: the body's slot. Integer texels: a small integer read as a float is
// denormal, and GLSL allows denormals to become 0.
uniform usamplerBuffer locals;
uniform uvec2 foreignChunks; // chunks [x, y) of another buffer; 0: all chunks of the stream

const uint rigid = 0u, inFrame = 2u; // qcLayersChunkKind

// The counters are 0, but the lists have one workgroup each at first; the cells' lists are empty.
void resetLists()
{
    uint stride = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    for (uint i = ITEM; i < COUNTER_WORDS + cellCount; i += stride)
        counters[i] = i >= COUNTER_WORDS ? none : uint(i < survivorCounter && (i & 15u) - 1u < 3u);
}

vec3 transformed(int v)
{
    uvec4 bits = texelFetch(locals, v);
    vec3 local = uintBitsToFloat(bits.xyz), result;
    for (uint axis = 0u; axis < 3u; axis++)
    {
        vec4 row;
        for (uint i = 0u; i < 4u; i++)
            row[i] = uintBitsToFloat(bodyWord(bits.w, 8u + axis * 4u + i));
        result[axis] = dot(row.xyz, local) + row.w;
    }
    return result;
}

// A denormal float converts as an integer: GLSL allows it to become 0 otherwise.
double exactly(uint bits)
{
    if ((bits & 0x7f800000u) != 0u)
        return double(uintBitsToFloat(bits));
    double magnitude = double(bits & 0x7fffffu) * 1.4012984643248170709e-45LF;
    return (bits >> 31) != 0u ? -magnitude : magnitude;
}

void main()
{
    bool isForeign = foreignChunks.y != 0u;
    if (!isForeign)
        resetLists();
    uint chunk = GROUP + foreignChunks.x, k = gl_LocalInvocationID.x, at = chunksAt + chunk * 4u;
    if (chunk >= (isForeign ? foreignChunks.y : chunkCount))
        return;

    uint first = stream[at], count = stream[at + 1u], word = stream[at + 2u], kind = stream[at + 3u] & 255u;
    if (k >= count)
        return;

    word += (isForeign ? 0u : floatsAt) + k * (stream[at + 3u] >> 8);
    vec3 position;
    if (kind == rigid)
        position = transformed(int(first + k));
    else if (kind == inFrame)
        position = uintBitsToFloat(uvec3(source[word], source[word + 1u], source[word + 2u]));
    else
    {
        dvec3 world = dvec3(exactly(source[word + axes.x]), exactly(source[word + axes.y]), exactly(source[word + axes.z]));
        // In double: the origin may be far away, compared with the scene's extent.
        precise dvec3 offset = world - origin;
        position = vec3(offset * unit);
    }
    outVertices[first + k] = vec4(position, 0.0);
}
