"""Products with a narrow factor as sums, in lookup tables: rules by which Yosys replaces cells.

A multiplier of 18 x 18 bits is wasted on a sign, or on a constant of few bits. A product is the sum
of one factor, shifted, over the digits of the other. A constant has canonical signed digits, of
which one of two neighbours is always zero (Reitwiesner 1960); a variable has its bits.
"""

SWAPPED = """
(* techmap_celltype = "$mul" *)
module swapped(A, B, Y);
    parameter A_SIGNED = 0, B_SIGNED = 0, A_WIDTH = 1, B_WIDTH = 1, Y_WIDTH = 1;
    input [A_WIDTH-1:0] A;
    input [B_WIDTH-1:0] B;
    output [Y_WIDTH-1:0] Y;
    \\$mul #(
        .A_SIGNED(B_SIGNED), .B_SIGNED(A_SIGNED), .A_WIDTH(B_WIDTH), .B_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)
    ) _TECHMAP_REPLACE_ (.A(B), .B(A), .Y(Y));
endmodule
"""

NARROW = """
(* techmap_celltype = "$mul" *)
module narrow(A, B, Y);  // signed digits of B: of a constant its canonical ones, of which few are not zero
    parameter A_SIGNED = 0, B_SIGNED = 0, A_WIDTH = 1, B_WIDTH = 1, Y_WIDTH = 1;
    parameter _TECHMAP_CONSTMSK_B_ = 0, _TECHMAP_CONSTVAL_B_ = 0;
    input [A_WIDTH-1:0] A;
    input [B_WIDTH-1:0] B;
    output [Y_WIDTH-1:0] Y;
    localparam KNOWN = &_TECHMAP_CONSTMSK_B_;
    localparam W = B_WIDTH + 2;
    localparam [B_WIDTH-1:0] BITS = _TECHMAP_CONSTVAL_B_;
    localparam [W-1:0] VALUE = {{2{B_SIGNED && BITS[B_WIDTH-1]}}, BITS};
    localparam [W-1:0] HALF = {VALUE[W-1], VALUE[W-1:1]};
    localparam [W-1:0] THREE = VALUE + HALF;
    localparam [W-1:0] PLUS = THREE & (HALF ^ THREE), MINUS = HALF & (HALF ^ THREE);
    wire [Y_WIDTH-1:0] a;
    wire [Y_WIDTH*(W+1)-1:0] sums;
    genvar i;
    generate
        if (A_SIGNED) assign a = $signed(A);
        else assign a = A;
        assign sums[0 +: Y_WIDTH] = 0;
        for (i = 0; i < W; i = i + 1) begin : digit
            wire [Y_WIDTH-1:0] before = sums[Y_WIDTH*i +: Y_WIDTH];
            wire [Y_WIDTH-1:0] after;
            if (KNOWN) begin
                if (PLUS[i]) assign after = before + (a << i);
                else if (MINUS[i]) assign after = before - (a << i);
                else assign after = before;
            end else if (i >= B_WIDTH) assign after = before;
            else if (B_SIGNED && i == B_WIDTH - 1) assign after = before - (B[i] ? a << i : 0);
            else assign after = before + (B[i] ? a << i : 0);
            assign sums[Y_WIDTH*(i+1) +: Y_WIDTH] = after;
        end
    endgenerate
    assign Y = sums[Y_WIDTH*W +: Y_WIDTH];
endmodule
"""
