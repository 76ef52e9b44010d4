// For the image only: boxes of triangles and of clusters, rounded outward to levels.
layout(std430, binding = 2) buffer Boxes { uint outGroups[]; };
layout(std430, binding = 5) buffer ClusterBoxes { uvec4 outClusterBoxes[]; };

void main()
{
    uint i = ITEM;
    if (i >= changedNodes * 8u)
        return;

    int cluster = int(activeNode(i >> 3) * 8u + (i & 7u));
    uvec4 clusterLower = uvec4(highestLevel), clusterUpper = uvec4(0u);
    for (int k = 0; k < 8; k += 2)
    {
        uvec4 lower[2], upper[2];
        findBox(cluster * 8 + k, lower[0], upper[0]);
        findBox(cluster * 8 + k + 1, lower[1], upper[1]);
        WRITE_TWO_OF_GROUP(outGroups, cluster * 24, k, lower, upper)
        clusterLower = min(clusterLower, min(lower[0], lower[1]));
        clusterUpper = max(clusterUpper, max(upper[0], upper[1]));
    }
    outClusterBoxes[cluster] = packBox(clusterLower, clusterUpper);
}
