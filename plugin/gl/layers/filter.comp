// Separating axes: what is surely further apart than the reach goes.
layout(std430, binding = 1) buffer Survivors { uvec2 outSurvivors[]; }; // places of triangles
uniform uint trianglePairCapacity, survivorCapacity;
uniform float pointError, reach; // in the frame

// The other corners of A and all of B, as seen from the first corner of A.
vec3 b, c, d, e, f;
float gap; // least distance along an axis of length 1

// Whatever the axis is, only the dot products have to be right.
bool separates(vec3 axis)
{
    float u = dot(axis, b), v = dot(axis, c), p = dot(axis, d), q = dot(axis, e), r = dot(axis, f);
    float size = abs(axis.x) + abs(axis.y) + abs(axis.z), least = size * gap;
    float above = min(p, min(q, r)) - max(0.0, max(u, v)), below = min(0.0, min(u, v)) - max(p, max(q, r));
    return max(above, below) > max(least, 1e-20);
}

void main()
{
    uint total = min(counters[trianglePairCounter], trianglePairCapacity);
    uint i = ITEM;
    if (i >= total)
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
    // Powers of two, so that no product below is lost to underflow; see layers.c.
    float up = uintBitsToFloat((254u << 23) - (floatBitsToUint(size) & 0x7f800000u));
    b *= up, c *= up, d *= up, e *= up, f *= up;
    gap = (4.0 * pointError + reach) * up * 1.0001 + 4e-6;

    // Edges and normals of both; a third of the axes a time, since most are done after the first.
    vec3 p0 = b, p1 = c, p2 = c - b, q0 = e - d, q1 = f - d, q2 = f - e, n = cross(p0, p1), m = cross(q0, q1);
    bool apart = separates(n);
    apart = separates(m) || apart;
    int third = 0;
    do
    {
        apart = separates(cross(p0, q0)) || apart;
        apart = separates(cross(p0, q1)) || apart;
        apart = separates(cross(p0, q2)) || apart;
        apart = separates(cross(n, p0)) || apart;
        apart = separates(cross(m, q0)) || apart;
        vec3 first = p0;
        p0 = p1, p1 = p2, p2 = first;
        first = q0;
        q0 = q1, q1 = q2, q2 = first;
        third++;
    } while (!apart && third < 3);
    if (!apart)
    {
        uint place = atomicAdd(counters[survivorCounter], 1u);
        if (place < survivorCapacity)
            outSurvivors[place] = uvec2(s, t);
    }
}
