// The nearest surface: its normal; its depth goes to the depth buffer. Follows normal.glsl.
out vec4 surfaceNormal;
void main()
{
    surfaceNormal = vec4(0.5 + 0.5 * findNormal(), 1.0);
}
