// Separating axes: rejects pairs that are proven farther apart than the query distance. One algorithm with
// kernels/separating_axis.inl.h: the same scale, gap and 17 axes (the processor also tries the line between the centres).
// Tests of `layers` run both with one body (QC_LAYERS_REFINE). Proof: plugin/docs/proofs/layers.md.
layout(std430, binding = 1) buffer Survivors { uvec2 outSurvivors[]; }; // triangle slots
uniform uint trianglePairCapacity, survivorCapacity;
uniform float pointError, queryDistance; // in the frame

// The other corners of A and all of B, relative to the first corner of A.
vec3 b, c, d, e, f;
float gap; // required distance along an axis of length 1

// Whether the cross product of two vectors separates the triangles by more than the query distance. The axis need not be
// exact, but must be equal in all dot products: GLSL may evaluate an expression that is not `precise` anew for each use,
// and round it differently.
bool separates(vec3 first, vec3 second)
{
    precise vec3 axis = cross(first, second);
    float u = dot(axis, b), v = dot(axis, c), p = dot(axis, d), q = dot(axis, e), r = dot(axis, f);
    float size = abs(axis.x) + abs(axis.y) + abs(axis.z), required = size * gap;
    float above = min(p, min(q, r)) - max(0.0, max(u, v)), below = min(0.0, min(u, v)) - max(p, max(q, r));
    return max(above, below) > max(required, 1e-20);
}

void main()
{
    MARK_FINISHED
    uint i = ITEM;
    if (i >= countOf(trianglePairCounter, trianglePairCapacity))
        return;

    uint word = texelFetch(trianglePairs, int(i)).x, above = texelFetch(clusterPairs, int(word >> 6)).x;
    uvec2 pair = texelFetch(nodePairs, int(above >> 6)).xy;
    uint s = (pair.x * 8u + (above & 7u)) * 8u + (word & 7u),
         t = (pair.y * 8u + (above >> 3 & 7u)) * 8u + (word >> 3 & 7u);
    uvec4 i0 = texelFetch(triangles, int(s)), i1 = texelFetch(triangles, int(t));
    vec3 a = texelFetch(vertices, int(i0.x)).xyz;
    b = texelFetch(vertices, int(i0.y)).xyz - a;
    c = texelFetch(vertices, int(i0.z)).xyz - a;
    d = texelFetch(vertices, int(i1.x)).xyz - a;
    e = texelFetch(vertices, int(i1.y)).xyz - a;
    f = texelFetch(vertices, int(i1.z)).xyz - a;
    vec3 largest = max(max(max(abs(b), abs(c)), max(abs(d), abs(e))), abs(f));
    float size = max(largest.x, max(largest.y, largest.z));
    // A power of two, so that no product below underflows.
    float up = uintBitsToFloat((254u << 23) - (floatBitsToUint(size) & 0x7f800000u));
    b *= up, c *= up, d *= up, e *= up, f *= up;
    gap = (4.0 * pointError + queryDistance) * up * 1.0001 + 4e-6;

    vec3 bc = c - b, de = e - d, df = f - d, ef = f - e;
    precise vec3 n = cross(b, c), m = cross(de, df);
    // No early exit: arithmetic costs less than branches.
    bool apart = separates(b, c);
    apart = separates(de, df) || apart;
    apart = separates(b, de) || apart;
    apart = separates(b, df) || apart;
    apart = separates(b, ef) || apart;
    apart = separates(c, de) || apart;
    apart = separates(c, df) || apart;
    apart = separates(c, ef) || apart;
    apart = separates(bc, de) || apart;
    apart = separates(bc, df) || apart;
    apart = separates(bc, ef) || apart;
    apart = separates(n, b) || apart;
    apart = separates(n, c) || apart;
    apart = separates(n, bc) || apart;
    apart = separates(m, de) || apart;
    apart = separates(m, df) || apart;
    apart = separates(m, ef) || apart;
    if (!apart)
    {
        uint at = atomicAdd(counters[survivorCounter], 1u);
        outSurvivors[min(at, survivorCapacity)] = uvec2(s, t);
    }
}
