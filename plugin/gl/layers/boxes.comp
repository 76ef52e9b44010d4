// Boxes of triangles and of clusters, rounded outward to levels.
layout(std430, binding = 1) buffer Boxes { uvec4 outBoxes[]; };
layout(std430, binding = 2) buffer ClusterBoxes { uvec4 outClusterBoxes[]; };
uniform uint nodeCount; // changed nodes: the first of activeNodes
uniform vec3 scale;
uniform vec4 slack;     // levels; w: of the diagonal

// Level 0 is the empty box's: its lower ends are the highest level, and what reaches to both ends would meet it.
uvec4 toLevels(vec4 x)
{
    return uvec4(clamp(x, 1.0, 32767.0));
}

void main()
{
    uint i = ITEM;
    if (i >= nodeCount * 8u)
        return;

    int cluster = int(texelFetch(activeNodes, int(i >> 3)).x * 8u + (i & 7u));
    uvec4 clusterLower = uvec4(0x7fffu), clusterUpper = uvec4(0u);
    for (int k = 0; k < 8; k++)
    {
        uvec4 t = texelFetch(triangles, cluster * 8 + k);
        bool exists = t.x != none;
        vec3 a = texelFetch(vertices, int(exists ? t.x : 0u)).xyz * scale,
             b = texelFetch(vertices, int(exists ? t.y : 0u)).xyz * scale,
             c = texelFetch(vertices, int(exists ? t.z : 0u)).xyz * scale;
        vec3 d = 0.5 * vec3(a.x + a.y, b.x + b.y, c.x + c.y);
        vec4 lower = vec4(min(a, min(b, c)), min(d.x, min(d.y, d.z))),
             upper = vec4(max(a, max(b, c)), max(d.x, max(d.y, d.z)));
        uvec4 l = toLevels(lower - slack), u = toLevels(upper + slack);
        outBoxes[cluster * 8 + k] = exists ? packBox(l, u) : emptyBox;
        clusterLower = exists ? min(clusterLower, l) : clusterLower;
        clusterUpper = exists ? max(clusterUpper, u) : clusterUpper;
    }
    outClusterBoxes[cluster] = packBox(clusterLower, clusterUpper);
}
