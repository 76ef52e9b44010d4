// Boxes of triangles and of clusters, rounded outward to levels.
#ifdef IMAGE_ONLY
layout(std430, binding = 1) buffer Boxes { uint outGroups[]; };
#else
layout(std430, binding = 1) buffer Boxes { uvec4 outBoxes[]; };
#endif
layout(std430, binding = 2) buffer ClusterBoxes { uvec4 outClusterBoxes[]; };
uniform uint nodeCount; // changed nodes: the first of activeNodes
uniform vec3 scale;
uniform vec4 slack;     // levels; w: of the diagonal

// Not below 1: an empty box ends at level 0 and begins at the highest, so it overlaps no other box.
uvec4 toLevels(vec4 x)
{
    return uvec4(clamp(x, 1.0, 32767.0));
}

void findBox(int slot, out uvec4 lower, out uvec4 upper)
{
    uvec4 t = texelFetch(triangles, slot);
    bool exists = t.x != none;
    vec3 a = texelFetch(vertices, int(exists ? t.x : 0u)).xyz * scale,
         b = texelFetch(vertices, int(exists ? t.y : 0u)).xyz * scale,
         c = texelFetch(vertices, int(exists ? t.z : 0u)).xyz * scale;
    vec3 d = 0.5 * vec3(a.x + a.y, b.x + b.y, c.x + c.y);
    vec4 low = vec4(min(a, min(b, c)), min(d.x, min(d.y, d.z))),
         high = vec4(max(a, max(b, c)), max(d.x, max(d.y, d.z)));
    lower = exists ? toLevels(low - slack) : uvec4(0x7fffu);
    upper = exists ? toLevels(high + slack) : uvec4(0u);
}

void main()
{
    uint i = ITEM;
    if (i >= nodeCount * 8u)
        return;

    int cluster = int(texelFetch(activeNodes, int(i >> 3)).x * 8u + (i & 7u));
    uvec4 clusterLower = uvec4(0x7fffu), clusterUpper = uvec4(0u);
    for (int k = 0; k < 8; k += 2)
    {
        uvec4 lower[2], upper[2];
        findBox(cluster * 8 + k, lower[0], upper[0]);
        findBox(cluster * 8 + k + 1, lower[1], upper[1]);
#ifdef IMAGE_ONLY
        WRITE_TWO_OF_GROUP(outGroups, cluster, k, lower, upper)
#else
        outBoxes[cluster * 8 + k] = packBox(lower[0], upper[0]);
        outBoxes[cluster * 8 + k + 1] = packBox(lower[1], upper[1]);
#endif
        clusterLower = min(clusterLower, min(lower[0], lower[1]));
        clusterUpper = max(clusterUpper, max(upper[0], upper[1]));
    }
    outClusterBoxes[cluster] = packBox(clusterLower, clusterUpper);
}
